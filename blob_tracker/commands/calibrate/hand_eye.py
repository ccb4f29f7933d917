"""calibrate hand_eye: how the camera sits on a pan/tilt, from turning it before a still light."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

from blob_tracker.calibration.hand_eye import (
    calibrate_hand_eye, HandEyeCalibration, HandEyeError, Joint,
)
from blob_tracker.calibration.hand_eye_picture import draw_hand_eye
from blob_tracker.commands.calibrate.ray_sources import rays_of, recorded_bearings
from blob_tracker.commands.calibrate.report import results_table, Row, row, tell_of
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.commands.sources import SourceError
from blob_tracker.ros.bags import Bag, opened, RecordingError
from blob_tracker.ros.errors import MessageError
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD, MRAD_PER_RAD
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

if TYPE_CHECKING:  # it needs ROS
    from blob_tracker.ros.endpoints.panning import JointSeries

Array = NDArray[np.float64]

FAILURES = (HandEyeError, RecordingError)
NEEDS_ROS = 'calibrate hand_eye needs ROS: source its setup file'
KIND = 'sensor_msgs/msg/JointState'
MM_PER_M, MS_PER_S = 1e3, 1e3
LENGTH_SIGMA = 0.01  # of a range by a tape measure, over it


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        'source', nargs='?', type=Path, metavar='BAG',
        help='of target/ray and joint_states, while both joints swung before a still light; '
             'without it both are listened to',
    )
    parser.add_argument('--ray', default='target/ray', help='topic of the bearings (%(default)s)')
    parser.add_argument(
        '--joint-states', default='joint_states', help='topic of the angles (%(default)s)'
    )
    parser.add_argument(
        '--joints', nargs=2, default=['pan', 'tilt'], metavar=('PAN', 'TILT'),
        help='names of the joints in it (pan tilt)',
    )
    parser.add_argument(
        '--joint-sigma', type=float, default=0.0, metavar='MRAD',
        help='standard deviation of an angle',
    )
    parser.add_argument(
        '--distance', nargs='+', type=float, metavar='M',
        help='of the light from the camera, m, and its standard deviation (default 1 %%)',
    )
    parser.add_argument(
        '--seconds', type=float, default=30.0, help='to listen where there is no bag (%(default)g)'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('hand_eye.yaml'), metavar='FILE',
        help='parameters of the tracker (%(default)s); the picture goes beside it, as .png',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png', arguments.source)
    if not 1.0 <= arguments.seconds <= 3600.0:
        raise UsageError(f'--seconds is {arguments.seconds:g}; it must be 1 to 3600')
    distance = arguments.distance
    if distance is not None and len(distance) > 2:
        raise UsageError('--distance has one number or two: M [SIGMA]')
    if arguments.joints[0] == arguments.joints[1]:
        raise UsageError('--joints are two')
    console = Console()
    if arguments.source is None:
        with console.status(f'turn both joints before the light, for {arguments.seconds:g} s'):
            bearings, stamps, angles = _live(arguments)
    else:
        with opened(arguments.source) as bag:
            bearings, _ = _of_topic(bag, arguments.ray)
            stamps, angles = _angles(bag, arguments.joint_states, arguments.joints)
    # Of one origin: that of the rays.
    first_ns = min((each.stamp_ns for each in bearings), default=0)
    times: list[Array] = [
        np.array([1e-9 * (stamp - first_ns) for stamp in each]) for each in stamps
    ]
    result = calibrate_hand_eye(
        rays_of([bearings])[0],
        *(Joint(when, np.array(turned)) for when, turned in zip(times, angles, strict=True)),
        joint_sigma=MRAD * arguments.joint_sigma,
        distance=None if distance is None else (
            distance[0], distance[1] if len(distance) == 2 else LENGTH_SIGMA * distance[0]),
    )
    _report(console, result)
    tell_of(console, arguments.out)
    arguments.out.write_text(_parameters(result, arguments.joints, arguments.joint_sigma))
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_hand_eye(picture, result)


def _of_topic(bag: Bag, name: str) -> tuple[list[Bearing], str]:
    """Return the bearings of a topic that may be in a namespace."""
    topics = [
        topic.name for topic in bag.topics
        if f'/{topic.name}'.endswith(f'/{name.lstrip("/")}')
    ]
    return recorded_bearings(bag, topics[:1] or [name])[topics[0] if topics else name]


def _live(
    arguments: argparse.Namespace
) -> tuple[list[Bearing], list[list[int]], list[list[float]]]:
    """Return the bearings that come, and stamps and angles as `_angles` does."""
    try:
        from blob_tracker.ros.endpoints.panning import live_panning
    except ImportError:
        raise SourceError(NEEDS_ROS) from None
    bearings, series = live_panning(
        arguments.ray, arguments.joint_states, arguments.joints, arguments.seconds)
    if not bearings:
        raise RecordingError(f'no ray came on {arguments.ray} in {arguments.seconds:g} s')
    return bearings, *_in_order(series, 'what came', arguments.joint_states)


def _angles(
    bag: Bag, name: str, joints: Sequence[str]
) -> tuple[list[list[int]], list[list[float]]]:
    """Return stamps, ns, and angles, rad, of each joint, in the order of the stamps."""
    try:
        from blob_tracker.ros.endpoints.panning import JointSeries
        from rclpy.serialization import deserialize_message
        from sensor_msgs.msg import JointState
    except ImportError:
        raise SourceError(NEEDS_ROS) from None
    topics = [
        topic for topic in bag.topics
        if topic.kind == KIND and f'/{topic.name}'.endswith(f'/{name.lstrip("/")}')
    ]
    if len(topics) != 1:
        raise RecordingError(f'{bag.path} has {len(topics)} topics {name} of the type {KIND}')
    series = JointSeries(joints)
    for message in bag.messages(topics):
        # Not by rosbags: it wants padding before the empty list of velocities.
        try:
            states = deserialize_message(bag.serialized(message), JointState)
        except Exception as error:  # what a damaged message makes it raise comes from anywhere
            raise RecordingError(
                f'{bag.path}, {name}: a message is not a {KIND}: {error}'
            ) from None
        try:
            series.take(states)
        except MessageError as error:
            raise RecordingError(f'{bag.path}, {name}: {error}') from None
    return _in_order(series, str(bag.path), name)


def _in_order(
    series: JointSeries, source: str, name: str
) -> tuple[list[list[int]], list[list[float]]]:
    """Return stamps and angles of each joint, once each has some."""
    for joint, angles in series.angles.items():
        if not angles:
            raise RecordingError(
                f'{source} has no angle of the joint {joint} on {name}; it has those of '
                f'{", ".join(sorted(series.names)) or "none"}: give --joints'
            )
    in_order = [sorted(angles.items()) for angles in series.angles.values()]
    return (
        [[stamp for stamp, _ in each] for each in in_order],
        [[angle for _, angle in each] for each in in_order],
    )


def _report(console: Console, result: HandEyeCalibration) -> None:
    """Print the table."""
    sigmas = result.sigmas
    unit, size = ('mm', MM_PER_M) if result.is_metric else ('of the range', 1.0)
    rows: list[Row] = []
    for name, axis, arm, own in (
        ('pan', result.pan_axis, result.pan_arm, 'y'),
        ('tilt', result.tilt_axis, result.tilt_arm, 'x'),
    ):
        index = 'xyz'.index(own)
        sign = math.copysign(1.0, axis[index])
        sigma = max(sigmas[f'{name}_axis_1'], sigmas[f'{name}_axis_2'])
        for other in (each for each in range(3) if each != index):
            # Of the line, whatever the sign of the joint.
            tilted = math.atan2(sign * axis[other], sign * axis[index])
            rows.append(row(
                f'{name} axis, {own} to {"xyz"[other]}', MRAD_PER_RAD * tilted,
                MRAD_PER_RAD * sigma, 'mrad',
            ))
        sigma = max(sigmas[f'{name}_arm_1'], sigmas[f'{name}_arm_2'])
        rows += [
            row(f'{name} arm {each}', size * value, size * sigma, unit)
            for each, value in zip('xyz', arm.tolist(), strict=True)
        ]
    rows.append(row('rays late', MS_PER_S * result.clock, MS_PER_S * sigmas['clock'], 'ms'))
    rows.append((
        'chi2 per degree', f'{result.chi2 / result.freedom:.2f}', '',
        f'{result.freedom} degrees',
    ))
    console.print(results_table(f'camera on its pan/tilt, {result.used} rays', rows))
    if result.left_out:
        console.print(f'- rays left out since the light was elsewhere: {result.left_out}')
    if result.factor > 1.0:
        console.print(
            f'- the residuals are {result.factor**0.5:.2f} times what the sigmas say, and those '
            'of the table were grown by it: a lens that is not calibrated well, backlash, or '
            'angles that need --joint-sigma'
        )
    if not result.is_metric:
        console.print('- the arms are over the range of the light: give --distance')


def _parameters(
    result: HandEyeCalibration, joints: Sequence[str], joint_sigma: float
) -> str:
    """Return the parameter file of the tracker, with the joints for a URDF as comments."""
    values = {
        # Quoted: 1, on and y are no strings to a reader of YAML.
        'joints.pan': json.dumps(joints[0]), 'joints.tilt': json.dumps(joints[1]),
        'joints.pan_reversed': str(bool(result.pan_axis[1] < 0.0)).lower(),
        'joints.tilt_reversed': str(bool(result.tilt_axis[0] < 0.0)).lower(),
        'stamp_offset': f'{result.clock:.6f}',
    }
    if joint_sigma:
        values['joints.sigma'] = f'{joint_sigma:.6f}'  # with a point: the parameter is a double
    unit = 'm' if result.is_metric else 'of the range of the light'
    lines = [
        '# python3 -m blob_tracker calibrate hand_eye. In the optical frame at both angles 0, for',
        f'# a URDF (positions {unit}):',
    ]
    for joint, axis, arm in (
        (joints[0], result.pan_axis, result.pan_arm),
        (joints[1], result.tilt_axis, result.tilt_arm),
    ):
        place, about = (
            ' '.join(f'{each:.6f}' for each in part.tolist()) for part in (arm, axis))
        lines.append(f'#   {joint}: <origin xyz="{place}"/> <axis xyz="{about}"/>')
    lines += ['/**/tracker:', '  ros__parameters:']
    lines += [f'    {name}: {value}' for name, value in values.items()]
    return '\n'.join([*lines, ''])

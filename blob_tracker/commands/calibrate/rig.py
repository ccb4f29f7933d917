"""calibrate rig: where cameras are, and their clocks, from a light that is waved before them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap

from blob_tracker.calibration.rays import Rays
from blob_tracker.calibration.rig import calibrate_rig, RigCalibration
from blob_tracker.calibration.rig_picture import draw_rig
from blob_tracker.calibration.rig_start import RigError
from blob_tracker.commands.calibrate.ray_sources import rays_of, recorded_bearings
from blob_tracker.commands.calibrate.report import (
    length_of, results_table, Row, row, tell_of,
)
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.nodes.interface.optical_frame import PITCH, ROLL, YAW
from blob_tracker.nodes.interface.triangulator import ANGLES, AXES, pose_of
from blob_tracker.ros.bags import Bag, opened, RecordingError
from blob_tracker.ros.endpoints.names import check_light, target_topic
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from rich.console import Console
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

FAILURES = (RecordingError, RigError)
POSE = (*AXES, *ANGLES)  # as static_transform_publisher has it
NUMBERS = 7  # of a camera in the covariance: turn, position, clock
MS_PER_S, MM_PER_M = 1e3, 1e3
WIDTH = 99


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.description = (
        'Where cameras are, how they are turned and how far their clocks are apart, from a bag in '
        'which one light was waved before all of them for half a minute: near and far, through '
        'the whole space. Each camera has a tracker in its own namespace, and a calibrated lens; '
        'record their rays, ros2 bag record /left/target/ray /right/target/ray.'
    )
    parser.add_argument('bag', type=Path, help='with the rays of all cameras')
    parser.add_argument(
        '--cameras', nargs='+', required=True, metavar='NAMESPACE',
        help="the cameras' namespaces, two or more; poses are in the frame of the first",
    )
    parser.add_argument('--light', default='', help='name of the coded light; a wand has its own')
    parser.add_argument(
        '--wand', nargs='+', metavar=('LIGHT', 'LIGHT M'),
        help='two coded lights on a stick, the distance between them, m, and its standard '
             'deviation (default 1 mm)',
    )
    parser.add_argument(
        '--baseline', nargs='+', metavar=('CAMERA', 'CAMERA M'),
        help='two cameras, their distance, m, and its standard deviation (default 1 mm), in place '
             'of a wand',
    )
    parser.add_argument(
        '--most-offset', type=float, default=0.2, metavar='S',
        help='between two clocks, at most (default %(default)s s)',
    )
    parser.add_argument(
        '--frame-id', default='map',
        help='frame of the poses: x ahead of the first camera, y to its left, z up '
             '(default %(default)s)',
    )
    parser.add_argument(
        '--out', type=Path, default=Path('rig.yaml'),
        help='parameters of the triangulator (%(default)s); the picture beside it',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png', arguments.bag)
    names = [name.strip('/') for name in arguments.cameras]
    wand = length_of('--wand', 'LIGHT LIGHT M [SIGMA]', arguments.wand)
    baseline = length_of('--baseline', 'CAMERA CAMERA M [SIGMA]', arguments.baseline)
    if wand and wand[0] == wand[1]:
        raise UsageError(f'--wand {wand[0]} {wand[1]}: a wand has two lights')
    if not arguments.frame_id or set(arguments.frame_id) & set('"\\\n'):
        raise UsageError('--frame-id must be the name of a frame')
    if wand and arguments.light:
        raise UsageError('--light is for one light; those of a wand are named with it')
    if not 0.0 <= arguments.most_offset <= 10.0:
        raise UsageError('--most-offset must be 0 to 10 s')
    lights = list(wand[:2]) if wand else [arguments.light]
    try:
        for light in filter(None, lights):
            check_light(light)
    except ParameterError as error:
        raise UsageError(str(error)) from None
    console = Console()
    with opened(arguments.bag) as bag:
        rays, frames = _rays(bag, names, lights)
    result = calibrate_rig(
        rays, names,
        baseline=(baseline[0].strip('/'), baseline[1].strip('/'), *baseline[2:])
        if baseline else None,
        wand=wand[2:] if wand else None,
        most_offset=arguments.most_offset,
    )
    _report(console, result)
    picture = arguments.out.with_suffix('.png')
    if result.is_metric:
        tell_of(console, arguments.out)
        arguments.out.write_text(_parameters(result, frames, lights, arguments))
    tell_of(console, picture)
    draw_rig(picture, result)
    if not result.is_metric:
        raise RigError(
            'no parameters are written, since the scale is unknown: give --wand or --baseline'
        )


def _rays(
    bag: Bag, names: Sequence[str], lights: Sequence[str]
) -> tuple[list[list[Rays]], list[str]]:
    """Return the rays of each camera to each light, and the frames that they are in."""
    found = recorded_bearings(
        bag, [_topic(name, light) for name in names for light in lights]
    )
    series = [found[_topic(name, light)] for name in names for light in lights]
    rays = rays_of([bearings for bearings, _ in series])
    count = len(lights)
    return (
        [rays[count * camera:count * (camera + 1)] for camera in range(len(names))],
        [frame for _, frame in series[count - 1::count]],
    )


def _topic(camera: str, light: str) -> str:
    """Return the topic of a camera's rays to a light."""
    return f'/{camera}/{target_topic(light)}/ray'


def _report(console: Console, result: RigCalibration) -> None:
    """Print the table and what is to be said about it."""
    unit, size = ('mm', MM_PER_M) if result.is_metric else ('', 1.0)
    rows: list[Row] = []
    sigmas = np.sqrt(np.diag(result.covariance)).reshape(-1, 7)
    for number, name in enumerate(result.names[1:], 1):
        for axis, value, sigma in zip(
            'xyz', result.positions[number], sigmas[number, 3:6], strict=True
        ):
            rows.append(row(f'{name} {axis}', size * value, size * sigma, unit))
        turn = Rotation.from_matrix(result.rotations[number]).magnitude()
        rows.append(row(
            f'{name} turned', MRAD_PER_RAD * turn,
            MRAD_PER_RAD * float(result.rotation_sigmas[number]), 'mrad',
        ))
        rows.append(row(
            f'{name} clock ahead', MS_PER_S * result.offsets[number],
            MS_PER_S * sigmas[number, 6], 'ms',
        ))
    rows.append((
        'chi2 per degree', f'{result.chi2 / max(result.freedom, 1):.2f}', '',
        f'{result.freedom} degrees',
    ))
    console.print(results_table(
        f'{len(result.names)} cameras, in the optical frame of {result.names[0]}', rows
    ))
    for note in result.notes:
        console.print(f'- {note}', markup=False)


def _parameters(
    result: RigCalibration, frames: Sequence[str], lights: Sequence[str],
    arguments: argparse.Namespace,
) -> str:
    """Return the parameter file: a triangulator of all cameras."""
    poses = [_pose(result, number) for number in range(len(result.names))]
    lines = [
        '# python3 -m blob_tracker calibrate rig: poses of the optical frames; x looks ahead of',
        f'# {result.names[0]}, y to its left, z up. For TF, in place of these, with use_tf:',
    ]
    if len(set(frames)) < len(frames):  # TF has one place for each
        frames = [f'{name}/{frame or "optical"}' for name, frame in zip(result.names, frames)]
        lines.append(
            f'# (rays of several cameras share one frame so far: set frame_id to {frames[0]} for '
            f'{result.names[0]}, and so on for the others)'
        )
    for name, frame, pose in zip(result.names, frames, poses, strict=True):
        options = ' '.join(f'--{key} {value}' for key, value in pose.items())
        lines.append(
            f'#   ros2 run tf2_ros static_transform_publisher {options} '
            f'--frame-id {arguments.frame_id} --child-frame-id {frame or name}'
        )
    lines.append('# Clocks, ahead of the first one (stamp_offset of that camera takes it off):')
    for name, offset, sigma in zip(
        result.names, result.offsets, result.offset_sigmas, strict=True
    ):
        lines.append(f'#   {name} {MS_PER_S * offset:+.3f} ms, sigma {MS_PER_S * sigma:.3f} ms')
    lines += [f'# {note}' for note in result.notes]
    lines += [
        '/**/triangulator:', '  ros__parameters:', f'    frame_id: "{arguments.frame_id}"',
        f'    cameras: [{", ".join(map(_quoted, result.names))}]',
    ]
    if len(lights) == 1 and lights[0]:
        lines.append(f'    light: "{lights[0]}"')
    for number, (name, pose) in enumerate(zip(result.names, poses, strict=True)):
        lines.append(
            f'    # sigma {MM_PER_M * result.position_sigmas[number]:.2f} mm and '
            f'{MRAD_PER_RAD * result.rotation_sigmas[number]:.3f} mrad'
        )
        lines += [f'    {pose_of(name)}.{key}: {value}' for key, value in pose.items()]
    lines += [
        '    # Of turns about their own axes, rad, and positions, m, of all cameras; row by row.',
        *wrap(
            f'pose_covariance: [{", ".join(map(_number, _triangle(result)))}]', WIDTH,
            initial_indent='    ', subsequent_indent='      ', break_on_hyphens=False,
        ),
    ]
    return '\n'.join([*lines, ''])


def _quoted(name: str) -> str:
    return f'"{name}"'


def _number(value: float) -> str:
    """Return a number of a list in YAML, which must have a point."""
    return f'{value:.8e}' if value else '0.0'


def _triangle(result: RigCalibration) -> list[float]:
    """Return the lower triangle of the poses' covariance where x looks ahead and z up."""
    upright = turn_of(ROLL, PITCH, YAW)
    turn = block_diag(*len(result.names) * [np.eye(3), upright])
    poses = np.arange(len(result.covariance)) % NUMBERS != NUMBERS - 1  # and no clocks
    covariance = turn @ result.covariance[np.ix_(poses, poses)] @ turn.T
    triangle: list[float] = covariance[np.tril_indices(len(covariance))].tolist()
    return triangle


def _pose(result: RigCalibration, number: int) -> dict[str, str]:
    """Return a camera's pose where x looks ahead and z up, if the first camera is level."""
    upright = turn_of(ROLL, PITCH, YAW)
    angles = Rotation.from_matrix(upright @ result.rotations[number]).as_euler('ZYX')
    numbers = (*(upright @ result.positions[number]), *angles[::-1])
    return {key: f'{value:.7f}' for key, value in zip(POSE, numbers, strict=True)}

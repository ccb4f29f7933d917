"""`calibrate imu`: how the IMU sits beside the camera, from turning both before a light."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.calibration.imu import calibrate_imu, ImuCalibration, ImuError
from blob_tracker.calibration.imu_picture import draw_imu
from blob_tracker.calibration.imu_problem import NAMES
from blob_tracker.commands.calibrate.ray_sources import rays_of
from blob_tracker.commands.calibrate.report import results_table, row, tell_of
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.commands.sources import SourceError
from blob_tracker.ros.bags import RecordingError
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from rich.console import Console

FAILURES = (ImuError, RecordingError)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        'source', nargs='?', type=Path, metavar='BAG',
        help='of target/ray and imu, while camera and IMU were turned before a light that stands '
             'still; without it both are listened to',
    )
    parser.add_argument('--ray', default='target/ray', help='topic of the bearings (%(default)s)')
    parser.add_argument('--imu', default='imu', help='topic of the IMU (%(default)s)')
    parser.add_argument(
        '--seconds', type=float, default=30.0, help='to listen, without a bag (%(default)g)'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('imu.yaml'), metavar='FILE',
        help='parameter file to write (%(default)s); the picture goes beside it, as .png',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png')
    if not 1.0 <= arguments.seconds <= 3600.0:
        raise UsageError(f'--seconds is {arguments.seconds:g}; it must be 1 to 3600')
    try:
        from blob_tracker.ros.endpoints.turning import live_turning, recorded_turning
        from blob_tracker.ros.messages.imu import angles_of
    except ImportError:
        raise SourceError('calibrate imu needs ROS: source its setup file') from None

    console = Console()
    if arguments.source is not None:
        bearings, rates, frame_id = recorded_turning(
            arguments.source, arguments.ray, arguments.imu
        )
    else:
        with console.status(f'turn camera and IMU, for {arguments.seconds:g} s'):
            bearings, rates, frame_id = live_turning(
                arguments.ray, arguments.imu, arguments.seconds
            )
    for count, topic in ((len(bearings), arguments.ray), (len(rates), arguments.imu)):
        if count < 2:
            raise ImuError(f'{count} messages came on {topic} that can be used')
    first_ns, samples = min(bearings), sorted(rates)
    rays, = rays_of([list(bearings.values())])
    result = calibrate_imu(
        rays.times, rays.directions, rays.covariance,
        1e-9 * (np.array(samples) - first_ns), np.array([rates[each] for each in samples]),
    )
    angles = angles_of(result.turn.T)
    _report(console, result, angles)
    tell_of(console, arguments.out)
    values: dict[str, object] = {'imu.enabled': 'true', 'imu.frame_id': f"'{frame_id}'"}
    values |= {
        f'imu.{name}': f'{value:.9f}' for name, value in (
            *zip(('roll', 'pitch', 'yaw'), angles, strict=True),
            ('stamp_offset', result.offset),
            *zip(('bias_x', 'bias_y', 'bias_z'), result.bias.tolist(), strict=True),
        )
    }
    lines = [
        '# By `python3 -m blob_tracker calibrate imu`.', '/**/tracker:', '  ros__parameters:',
        *(f'    {name}: {value}' for name, value in values.items()),
    ]
    arguments.out.write_text('\n'.join(lines) + '\n')
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_imu(picture, result)


def _report(
    console: Console, result: ImuCalibration, angles: tuple[float, float, float]
) -> None:
    """Print the table."""
    sigmas = dict(zip(NAMES, result.sigmas.tolist(), strict=True))
    rows = [
        row(f'imu.{name}', angle, None, 'rad')
        for name, angle in zip(('roll', 'pitch', 'yaw'), angles, strict=True)
    ]
    rows += [
        row(
            f'error about {axis} of the camera', 0.0, MRAD_PER_RAD * sigmas[f'turn_{axis}'], 'mrad'
        )
        for axis in 'xyz'
    ]
    rows.append(row('stamps late', 1e3 * result.offset, 1e3 * sigmas['offset'], 'ms'))
    rows += [
        row(f'bias {axis}', MRAD_PER_RAD * value, MRAD_PER_RAD * sigmas[f'bias_{axis}'], 'mrad/s')
        for axis, value in zip('xyz', result.bias.tolist(), strict=True)
    ]
    rows.append(row(
        'scale, or focal length', 100.0 * result.scale, 100.0 * sigmas['scale'], '% too small'
    ))
    rows.append(row('noise', MRAD_PER_RAD * result.noise, None, 'mrad/s/√Hz'))
    rows.append(row('intervals left out', 100.0 * result.stray, None, '%'))
    console.print(results_table(f'IMU beside the camera, {len(result.times)} intervals', rows))

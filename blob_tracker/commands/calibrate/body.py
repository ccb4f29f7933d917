"""calibrate body: where the lights are on a body, from turning it before one camera."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from blob_tracker.calibration.body import BodyCalibration, calibrate_body, check_distance
from blob_tracker.calibration.body_picture import draw_body
from blob_tracker.calibration.body_start import BodyCalibrationError
from blob_tracker.camera.yaml_file import CalibrationError
from blob_tracker.commands.calibrate.ray_sources import lights_seen, rays_of
from blob_tracker.commands.calibrate.report import (
    length_of, results_table, Row, row, tell_of,
)
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.constellation import Body, ConstellationError, write_body
from blob_tracker.ros.bags import RecordingError
from blob_tracker.ros.endpoints.names import check_light
from blob_tracker.ros.errors import ParameterError
from rich.console import Console

FAILURES = (BodyCalibrationError, CalibrationError, ConstellationError, RecordingError)
MM_PER_M = 1e3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.description = (
        'Where the lights are on a rigid body, from turning it before one calibrated camera for '
        'half a minute: by 30 degrees and more to either side, and up and down. The lights have '
        'names (flash.codes); record their rays, or let track write them into a table.'
    )
    parser.add_argument(
        'source', nargs='?', type=Path, metavar='SOURCE',
        help='a bag with target/NAME/ray of each light, or the track.csv of track; without it '
             'the topics are listened to',
    )
    parser.add_argument(
        '--distance', nargs='+', metavar=('LIGHT', 'LIGHT M'),
        help='two lights, the distance between them, m, and its standard deviation (default '
             '1 mm); it sets the size',
    )
    parser.add_argument(
        '--lights', nargs='+', default=[], metavar='LIGHT',
        help='of the body, four or more (default: all that SOURCE has)',
    )
    parser.add_argument(
        '--frame', nargs=3, default=[], metavar=('ORIGIN', 'X', 'Y'),
        help="lights that make the body's frame: its origin, one on the x axis, one on the side "
             'of y (default: the two of --distance, and the one that is furthest from their line)',
    )
    parser.add_argument(
        '--camera', default='', metavar='NAMESPACE', help="of the camera's topics (default none)"
    )
    parser.add_argument(
        '--seconds', type=float, default=30.0,
        help='to listen, without a SOURCE (%(default)g)',
    )
    parser.add_argument(
        '--out', type=Path, default=Path('body.yaml'), metavar='FILE',
        help='body file of the node constellation (%(default)s); the picture beside it',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png', arguments.source)
    distance = length_of('--distance', 'LIGHT LIGHT M [SIGMA]', arguments.distance)
    check_distance(distance)
    if not 1.0 <= arguments.seconds <= 3600.0:
        raise UsageError(f'--seconds is {arguments.seconds:g}; it must be 1 to 3600')
    if arguments.source is None and not arguments.lights:
        raise UsageError('give SOURCE, or with --lights the names of those to listen to')
    try:
        for light in arguments.lights:
            check_light(light)
    except ParameterError as error:
        raise UsageError(str(error)) from None
    console = Console()
    with console.status(
        'reading' if arguments.source else f'turn the body, for {arguments.seconds:g} s'
    ):
        seen = lights_seen(
            arguments.source, arguments.lights, arguments.camera, arguments.seconds)
        result = calibrate_body(
            rays_of(list(seen.values())), list(seen), distance=distance, frame=arguments.frame,
        )
    _report(console, result)
    picture = arguments.out.with_suffix('.png')
    if result.is_metric:
        body = Body(result.names, result.places, result.sigmas, result.size_sigma)
        tell_of(console, arguments.out)
        write_body(arguments.out, body, _comments(result))
    tell_of(console, picture)
    draw_body(picture, result)
    if not result.is_metric:
        raise BodyCalibrationError(
            'no body file is written, since the size is unknown: give --distance'
        )


def _report(console: Console, result: BodyCalibration) -> None:
    """Print the table and what is to be said about it."""
    unit, size = ('mm', MM_PER_M) if result.is_metric else ('', 1.0)
    rows: list[Row] = []
    for name, place, sigma in zip(result.names, result.places, result.sigmas, strict=True):
        rows += [
            row(f'{name} {axis}', size * value, size * sigma, unit)
            for axis, value in zip('xyz', place.tolist(), strict=True)
        ]
    if result.is_metric:
        rows.append(row('size, by the distance', 100.0, 100.0 * result.size_sigma, '%'))
    rows.append(row('turned, in all', math.degrees(result.turned), None, 'degrees'))
    rows.append((
        'chi2 per degree', f'{result.chi2 / max(result.freedom, 1):.2f}', '',
        f'{result.freedom} degrees',
    ))
    console.print(results_table(f'{len(result.names)} lights; {_frame(result)}', rows))
    for note in result.notes:
        console.print(f'- {note}', markup=False)


def _frame(result: BodyCalibration) -> str:
    """Say what the frame is."""
    origin, along, beside = result.frame
    return f'origin {origin}, x to {along}, y on the side of {beside}'


def _comments(result: BodyCalibration) -> list[str]:
    """Return what the file tells of its making."""
    return [
        f'python3 -m blob_tracker calibrate body, {int(result.used.sum())} rays',
        f'm; {_frame(result)}; z by the right hand',
        'sigma: of a position among the others along an axis; size_sigma: by the distance',
        *result.notes,
    ]

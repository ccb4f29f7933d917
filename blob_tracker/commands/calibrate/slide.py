"""calibrate slide: pixels per millimetre, and the focal length where the range is known."""

from __future__ import annotations

import argparse

from blob_tracker.calibration.slide import (
    Bend, calibrate_slide, SlideCalibration, SlideError, TABLE,
)
from blob_tracker.calibration.slide_picture import draw_slide
from blob_tracker.commands.calibrate.report import results_table, row, tell_of
from blob_tracker.commands.calibrate.stations import add_stations, stations
from blob_tracker.commands.calibrate.stations_file import SLIDE, Stations, StationsError
from blob_tracker.commands.exit_code import UsageError
from rich.console import Console

FAILURES = (SlideError, StationsError)
BENDS = {
    'across': 'the path in the picture is curved: the lens distorts, or the slide is not straight',
    'along': 'the steps in the picture grow towards one end: the image plane is not parallel to '
    'the slide, or the lens distorts; turn the camera until both ends agree',
    'along, odd': 'the steps in the picture grow, or shrink, towards both ends: the lens '
    'distorts; the scale is a mean over the travel',
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_stations(parser, (SLIDE,))
    parser.add_argument(
        '--slide-sigma',
        type=float,
        default=0.0,
        metavar='MM',
        help='standard deviation of a reading; 0.0073 for a caliper that shows 0.001 inch',
    )
    parser.add_argument(
        '--range', type=float, metavar='MM', help='of the control point from the lens'
    )
    parser.add_argument(
        '--range-sigma', type=float, default=0.0, metavar='MM', help='its standard deviation'
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    if arguments.range is not None and not arguments.range > 0.0:
        raise UsageError('--range must be above 0 mm')
    if arguments.range_sigma < 0.0 or (arguments.range_sigma and arguments.range is None):
        raise UsageError('--range-sigma must be 0 or more and counts with --range only')
    measured = stations(arguments, (SLIDE,))
    result = calibrate_slide(
        measured.settings[:, 0],
        measured.pixels,
        pixel_sigma=measured.sigma,
        slide_sigma=arguments.slide_sigma,
    )
    console = Console()
    _report(console, result, measured, arguments)
    picture = arguments.measurements.with_suffix('.png')
    tell_of(console, picture)
    draw_slide(picture, measured.settings[:, 0], result)


def _report(
    console: Console, result: SlideCalibration, measured: Stations, arguments: argparse.Namespace
) -> None:
    """Print the table and what is to be said about it."""
    rows = [
        row('scale', *result.pixels_per_mm, 'px/mm'),
        row('direction of the path', *result.direction, 'mrad'),
    ]
    rows += [
        row(f'slide for {shift:.2f} px', *result.displacement(shift), 'mm') for shift in TABLE
    ]
    if arguments.range is not None:
        focal = result.focal_length(arguments.range, arguments.range_sigma)
        rows.append(row('focal length', *focal, 'px'))
    rows += [
        row(f'bend, {bend.kind}', bend.pixels, bend.sigma, 'px') for bend in result.bends
    ]
    rows.append(row('residuals, rms', float((result.residuals**2).mean() ** 0.5), None, 'px'))
    console.print(results_table(f'camera on its slide, {len(measured.pixels)} stations', rows))
    for bend in result.bends:
        if bend.significant:
            console.print(f'- {_sentence(bend)}')
    roll, sigma = result.roll
    if abs(roll) > 3.0 * sigma:
        way = 'clockwise' if roll > 0.0 else 'counter-clockwise'
        console.print(
            f'- the camera is level with the slide after a turn {way} by {abs(roll):.1f} mrad, '
            'seen from behind it'
        )
    if result.factor > 1.0 and (measured.sigma is not None or arguments.slide_sigma):
        console.print(
            f'- the residuals are {result.factor ** 0.5:.1f} times what the sigmas say; those of '
            'the table are grown by as much'
        )
    pitch = 1.0 / result.pixels_per_mm[0]
    if not 1e-3 < pitch < 1e3:  # mm: a microscope, or a target kilometres away
        console.print(
            f'- a pixel would be {pitch:.3g} mm in the world; is the unit of the slide right? The '
            "column's name says it: slide_mm, slide_um or slide_in"
        )


def _sentence(bend: Bend) -> str:
    return f'{BENDS[bend.kind]} ({abs(bend.pixels):.3f} ± {bend.sigma:.3f} px)'

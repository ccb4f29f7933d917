"""`calibrate line_time`: how fast a rolling shutter reads its lines, from the bands of a lamp."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.calibration.line_time import (
    LineTimeError, LineTimeMeasurement, measure_line_time,
)
from blob_tracker.calibration.line_time_picture import draw_line_time
from blob_tracker.commands.calibrate.report import results_table, row, tell_of
from blob_tracker.commands.exit_code import check_out
from blob_tracker.commands.parser import number
from blob_tracker.commands.sources import add_source
from blob_tracker.commands.sources.shown_frames import shown_frames
from rich.console import Console

FAILURES = (LineTimeError,)
LIVE_FRAMES = 100
NODES = ('camera', 'segmenter', 'locator')  # that have the parameter


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_source(parser, 'a still wall in the light of a lamp on the mains, or of an LED with PWM')
    parser.add_argument(
        '--frequency', type=_frequency, metavar='HZ',
        help='of the light: 100 of a lamp on mains of 50 Hz, 120 on 60 Hz, or that of a PWM; left '
        'out, one of the first two, as far as the stamps say which',
    )
    parser.add_argument(
        '--out', type=Path, default=Path('line_time.yaml'),
        help='parameter file to write (%(default)s); the picture goes beside it, as .png',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png')
    console = Console()
    shown = shown_frames(arguments, console, 'reading the lines', live_frames=LIVE_FRAMES)
    measurement = measure_line_time(
        ((seconds, pixels) for _, seconds, pixels, _ in shown), arguments.frequency
    )
    _report(console, measurement)
    tell_of(console, arguments.out)
    arguments.out.write_text(_parameters(measurement))
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_line_time(picture, measurement)
    console.print(f'-p line_time:={measurement.line_time:.6g}', markup=False, highlight=False)


def _report(console: Console, measurement: LineTimeMeasurement) -> None:
    """Print the table and what is to be said about it."""
    count, height = measurement.profiles.shape
    line_time, sigma = 1e6 * measurement.line_time, 1e6 * measurement.sigma
    rows = [
        row('line time', line_time, sigma, 'us'),
        row('readout', abs(line_time) * (height - 1) / 1e3, sigma * (height - 1) / 1e3, 'ms'),
        row('spacing of the bands', measurement.spacing, None, 'lines'),
        row('bands in the picture', measurement.bands, None, ''),
        row('their amplitude', 100.0 * measurement.contrast, None, '% of the mean'),
        row('frequency of the light', measurement.frequency, None, 'Hz'),
    ]
    console.print(results_table(f'line time, {count} frames of {height} lines', rows))
    console.print(
        '- a frequency that is off by 1 % makes the line time off by 1 %; that of the mains is '
        'true to 0.2 %'
    )
    if not measurement.directed:
        console.print(
            '- whether the first line is exposed first is unknown, and assumed: a lamp on the '
            'mains and stamps at another frame rate may show it'
        )


def _parameters(measurement: LineTimeMeasurement) -> str:
    """Return the content of the parameter file."""
    return (
        f'# By `python3 -m blob_tracker calibrate line_time`, of {len(measurement.profiles)} '
        f'frames in a light of {measurement.frequency:g} Hz.\n'
        f'# Standard deviation: {measurement.sigma:.2g} s.\n'
        + ''.join(
            f'\n/**/{node}:\n  ros__parameters:\n    line_time: {measurement.line_time:.10f}\n'
            for node in NODES
        )
    )


def _frequency(word: str) -> float:
    value = number(word)
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f'{word} must be above 0')
    return value

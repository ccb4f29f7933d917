"""calibrate jitter: the horizontal offset of each line of an analogue grabber."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from blob_tracker.calibration.edge import EdgeError
from blob_tracker.calibration.line_jitter import LineJitterMeasurement, measure_line_jitter
from blob_tracker.calibration.line_jitter_picture import draw_line_jitter
from blob_tracker.camera import CalibrationError
from blob_tracker.commands.calibrate.report import results_table, Row, row, tell_of
from blob_tracker.commands.exit_code import check_out
from blob_tracker.commands.sources import add_source
from blob_tracker.commands.sources.shown_frames import shown_frames
from blob_tracker.types import Pixels
import numpy as np
from rich.console import Console

FAILURES = (CalibrationError, EdgeError)
WARM = 0.05  # px from frame to frame: a warm camera's (Lenz and Fritsch; thesis, 2.2.4)
COLD = 2.0 * WARM
LIVE_FRAMES = 100
TOGETHER = 0.3  # correlation of neighbouring lines: half a blob's lines then count no longer
OFF_AXIS = 0.1  # of the width, from the middle, where lenses bend straight edges visibly


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_source(parser, 'a still, straight, nearly vertical edge from top to bottom')
    parser.add_argument(
        '--progressive', action='store_true', help='the lines are not those of two fields in turn'
    )
    parser.add_argument(
        '--out',
        type=Path,
        default=Path('line_jitter.yaml'),
        help='for the parameter line_jitter_url of the locator (%(default)s); the picture beside',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png')
    console = Console()
    width = 0

    def pixels() -> Iterator[Pixels]:
        nonlocal width
        for _, _, frame, _ in shown_frames(
            arguments, console, 'placing the edge', live_frames=LIVE_FRAMES, woven=True
        ):
            width = frame.shape[1]
            yield frame

    measurement = measure_line_jitter(pixels(), fields=1 if arguments.progressive else 2)
    _report(console, measurement, width)
    tell_of(console, arguments.out)
    measurement.jitter.to_yaml(
        arguments.out,
        [
            f'python3 -m blob_tracker calibrate jitter, {len(measurement.places)} frames',
            'px; offset and standard deviation of each line, less a straight line over all',
        ],
    )
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_line_jitter(picture, measurement)


def _between(measurement: LineJitterMeasurement) -> list[Row]:
    """Return the row of the distance between the two fields, where there are two."""
    if measurement.fields == 1:
        return []
    offsets = measurement.jitter.offsets
    apart = float(offsets[1::2].mean() - offsets[::2].mean())
    return [row('odd lines less even', apart, measurement.jitter.sigma_between_fields, 'px')]


def _report(console: Console, measurement: LineJitterMeasurement, width: int) -> None:
    """Print the table and what is to be said about it."""
    jitter = measurement.jitter
    sigma = float(np.sqrt(np.mean(jitter.sigma**2)))
    start, slope = measurement.edge
    middle = start + slope * 0.5 * len(jitter.offsets)
    rows = [
        row('offsets, highest less lowest', float(np.ptp(jitter.offsets)), sigma, 'px'),
        row('offsets, rms', float(np.sqrt(np.mean(jitter.offsets**2))), sigma, 'px'),
        row('from frame to frame', jitter.sigma_from_frame_to_frame, None, 'px'),
        *_between(measurement),
        row('noise of the edge in a line', measurement.noise, None, 'px'),
        row('blur of the edge', measurement.edge_sigma, None, 'px'),
        row('slope of the edge', slope, None, 'px/line'),
        row('lines measured', float(measurement.measured.sum()), None, ''),
    ]
    lines, count = len(jitter.offsets), len(measurement.places)
    console.print(results_table(f'line jitter, {lines} lines, {count} frames', rows))
    if jitter.sigma_from_frame_to_frame > COLD:
        console.print(
            f'- the lines move by more than {COLD} px from frame to frame, those of a warm camera '
            f'by {WARM}: leave it on for half an hour and measure again'
        )
    if measurement.between_neighbours > TOGETHER:
        console.print(
            '- neighbouring lines move together (correlation '
            f'{measurement.between_neighbours:.2f}): the jitter from frame to frame averages '
            'out less over a blob than its covariance will say'
        )
    if abs(middle - 0.5 * width) > OFF_AXIS * width:
        console.print(
            f'- the edge is at x = {middle:.0f} px of {width}: away from the middle a lens bends '
            'a straight edge, and the bow is taken for jitter'
        )
    if slope != 0.0 and abs(slope) * lines < 1.0:
        console.print(
            '- the edge crosses less than one pixel from top to bottom: lean it by two or three, '
            'so that what the fit is off within a pixel averages out'
        )

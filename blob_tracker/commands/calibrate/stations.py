"""Measurements at known stations: from a CSV file, or taken live into one."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from blob_tracker.commands.calibrate.live_stations import measure_stations
from blob_tracker.commands.calibrate.stations_file import Quantity, read_stations, Stations
import numpy as np

# Of a station, whose weight follows from its own scatter: of 5 centroids the chi-square of the
# camera is twice what it should be, of 20 it is right within 5 %.
LEAST_COUNT = 10


def add_stations(parser: argparse.ArgumentParser, quantities: Sequence[Quantity]) -> None:
    """
    Declare MEASUREMENTS and the options of measuring live.

    Parameters
    ----------
    parser : ArgumentParser
        Of the calibration.
    quantities : sequence of Quantity
        What is set at each station.

    """
    header = ','.join(quantity.column for quantity in quantities)
    parser.add_argument(
        'measurements',
        metavar='MEASUREMENTS',
        type=Path,
        help=f'CSV file with the header {header},x,y and, if known, sigma_x,sigma_y (px); '
        '--live writes it',
    )
    parser.add_argument(
        '--live',
        action='store_true',
        help='measure now: average target/centroid at each station into MEASUREMENTS, and '
        'continue an unfinished file',
    )
    parser.add_argument(
        '--topic', default='target/centroid', help='centroids to average (%(default)s)'
    )
    parser.add_argument(
        '--count', type=_count, default=20, help='centroids a station (%(default)s)'
    )
    for quantity in quantities:
        parser.add_argument(
            f'--{quantity.name}',
            type=_steps,
            metavar='FIRST:LAST:COUNT',
            help=f'stations of {quantity.name} to be led through, {quantity.unit}; '
            'else it is asked for each time',
        )


def stations(arguments: argparse.Namespace, quantities: Sequence[Quantity]) -> Stations:
    """
    Return the measurements, after taking them where that is asked for.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_stations` filled.
    quantities : sequence of Quantity
        The same.

    Raises
    ------
    StationsError
        If there are none, or the file is not as it must be.
    KeyboardInterrupt
        On Ctrl-C; what was measured until then is in the file.

    """
    if arguments.live:
        measure_stations(arguments, quantities)
    return read_stations(arguments.measurements, quantities)


def _steps(words: str) -> list[float]:
    """Return the stations of FIRST:LAST:COUNT."""
    try:
        first, last, count = words.split(':')
        if int(count) < 1:
            raise ValueError
        return np.linspace(float(first), float(last), int(count)).tolist()
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{words}' is not FIRST:LAST:COUNT, -200:200:5 say"
        ) from None


def _count(word: str) -> int:
    if not word.isdecimal() or int(word) < LEAST_COUNT:
        raise argparse.ArgumentTypeError(
            f'{word} must be {LEAST_COUNT} or more: fewer do not show their own scatter'
        )
    return int(word)

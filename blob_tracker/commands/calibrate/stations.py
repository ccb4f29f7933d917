"""Measurements at known stations: from a CSV file, or taken live into one."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
import csv
from dataclasses import dataclass
from itertools import product
from math import isfinite
from pathlib import Path

from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

PIXELS = ('x', 'y')
SIGMAS = ('sigma_x', 'sigma_y')
# Of a station, whose weight follows from its own scatter: of 5 centroids the chi-square of the
# camera is twice what it should be, of 20 it is right within 5 %.
LEAST_COUNT = 10


class StationsError(ValueError):
    """Measurements that cannot be used; the message says what is wrong and what is right."""


@dataclass(frozen=True)
class Quantity:
    """
    What is set at a station.

    Parameters
    ----------
    name : str
        'pan', say; the column is its name and its unit, pan_mrad.
    units : dict
        Unit to its size in the unit of the result; the first is written to new files.

    """

    name: str
    units: dict[str, float]

    @property
    def unit(self) -> str:
        """Return the unit of new files."""
        return next(iter(self.units))

    @property
    def column(self) -> str:
        """Return the column of new files."""
        return f'{self.name}_{self.unit}'


PAN = Quantity('pan', {'mrad': MRAD, 'deg': np.pi / 180.0, 'rad': 1.0})
TILT = Quantity('tilt', PAN.units)
SLIDE = Quantity('slide', {'mm': 1.0, 'um': 1e-3, 'in': 25.4})


@dataclass(frozen=True)
class Stations:
    """
    What was measured.

    Parameters
    ----------
    settings : (n, q) array
        Of the quantities, in the unit of the result: rad or mm.
    pixels : (n, 2) array
        x, y, px.
    sigma : (n, 2) array or None
        Their standard deviations, px.

    """

    settings: NDArray[np.float64]
    pixels: NDArray[np.float64]
    sigma: NDArray[np.float64] | None


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
        help=f'CSV file with the header {header},x,y and, where they are known, sigma_x,sigma_y '
        '(px); with --live it is written',
    )
    parser.add_argument(
        '--live',
        action='store_true',
        help='measure now: average target/centroid at each station into MEASUREMENTS, and go on '
        'where such a file ends',
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
        Where there are none, or the file is not as it must be.
    KeyboardInterrupt
        On Ctrl-C; what was measured until then is in the file.

    """
    if arguments.live:
        _measure(arguments, quantities)
    return read_stations(arguments.measurements, quantities)


def read_stations(path: Path, quantities: Sequence[Quantity]) -> Stations:
    """
    Read a CSV file of measurements.

    Parameters
    ----------
    path : Path
        Its first line names the columns: each quantity with its unit (pan_mrad, pan_deg ...), x,
        y, and sigma_x, sigma_y or neither; lines that begin with # say nothing.
    quantities : sequence of Quantity
        What must be there.

    Returns
    -------
    Stations
        In the units of the result.

    Raises
    ------
    StationsError
        Where the file is missing, lacks a column, or holds what is no number.

    """
    try:
        text = path.read_text(encoding='utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        raise StationsError(f'cannot read the measurements {path}: {error}') from None
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith('#')
    ]
    rows = list(csv.reader(line for _, line in lines))
    if not rows:
        raise StationsError(f'{path} is empty; its first line is {_header(quantities)}')
    columns = [name.strip().lower() for name in rows[0]]
    names, sizes = _columns(path, columns, quantities)
    has_sigma = [name in columns for name in SIGMAS]
    if any(has_sigma) and not all(has_sigma):
        raise StationsError(f'{path} has one of sigma_x and sigma_y; give both or neither')
    wanted = [*names, *PIXELS, *(SIGMAS if all(has_sigma) else ())]
    places = [columns.index(name) for name in wanted]
    values = []
    for (number, _), row in zip(lines[1:], rows[1:]):
        if len(row) != len(columns):
            raise StationsError(
                f'{path}, line {number}: {len(row)} values for {len(columns)} columns'
            )
        values.append([_number(path, number, columns[place], row[place]) for place in places])
    if not values:
        raise StationsError(f'{path} has a header and no measurements')
    table = np.array(values)
    count = len(names)
    return Stations(
        settings=table[:, :count] * sizes,
        pixels=table[:, count:count + 2],
        sigma=table[:, count + 2:] if all(has_sigma) else None,
    )


def _columns(
    path: Path, columns: list[str], quantities: Sequence[Quantity]
) -> tuple[list[str], list[float]]:
    """Return the column of each quantity and the size of its unit."""
    names, sizes = [], []
    for quantity in quantities:
        there = [unit for unit in quantity.units if f'{quantity.name}_{unit}' in columns]
        if len(there) != 1:
            allowed = ' or '.join(f'{quantity.name}_{unit}' for unit in quantity.units)
            raise StationsError(
                f'{path} has the columns {", ".join(columns)}; there must be one of {allowed}: '
                f'the first line is {_header(quantities)}'
            )
        names.append(f'{quantity.name}_{there[0]}')
        sizes.append(quantity.units[there[0]])
    for name in PIXELS:
        if name not in columns:
            raise StationsError(
                f'{path} has no column {name}; the first line is {_header(quantities)}'
            )
    return names, sizes


def _header(quantities: Sequence[Quantity]) -> str:
    names = [*(quantity.column for quantity in quantities), *PIXELS]
    return ','.join(names) + '[,sigma_x,sigma_y]'


def _number(path: Path, line: int, column: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float('nan')
    if not isfinite(value):
        raise StationsError(
            f'{path}, line {line}: {column} is {word.strip()!r}; it must be a number'
        )
    if column in SIGMAS and value <= 0.0:
        raise StationsError(f'{path}, line {line}: {column} is {value:g} px; it must be above 0')
    return value


def _measure(arguments: argparse.Namespace, quantities: Sequence[Quantity]) -> None:
    """Take stations until the user ends, each written at once."""
    try:
        from blob_tracker.ros.endpoints.live_centroids import LiveCentroids, NoCentroidsError
    except ImportError:
        raise StationsError('--live needs ROS: source its setup file') from None

    console = Console(stderr=True)
    joints = getattr(arguments, 'joints', None) or ()
    path: Path = arguments.measurements
    done = 0
    columns = [*(quantity.column for quantity in quantities), *PIXELS, *SIGMAS]
    begun = path.read_text(encoding='utf-8-sig', errors='replace') if path.is_file() else ''
    if begun:
        header, *others = begun.splitlines()
        if header.strip() != ','.join(columns):
            raise StationsError(
                f'{path} cannot be gone on with: its first line is not {",".join(columns)}'
            )
        done = len(read_stations(path, quantities).pixels) if others else 0
        console.print(f'going on after the {done} stations of {path}')
    try:
        with (
            LiveCentroids(arguments.topic, joints) as centroids,
            open(path, 'a', encoding='utf-8', newline='') as file,
        ):
            if not begun:
                file.write(','.join(columns) + '\n')
            elif not begun.endswith('\n'):  # an editor's
                file.write('\n')
            for settings in _visits(arguments, quantities, done, measured=bool(joints)):
                while True:
                    try:
                        mean, sigma, angles = centroids.mean(arguments.count)
                        break
                    except NoCentroidsError as error:
                        console.print(f'[red]{error}[/red]')
                        if _ask('Enter tries this station again, q ends: '):
                            return
                if joints:
                    settings = [
                        angle / quantity.units[quantity.unit]
                        for angle, quantity in zip(angles.tolist(), quantities)
                    ]
                # A scatter of exactly nothing is no certainty: the last digit that is written.
                values = [*settings, *mean.tolist(), *np.maximum(sigma, 1e-6).tolist()]
                file.write(','.join(f'{value:.6f}' for value in values) + '\n')
                file.flush()
                console.print(
                    f'x {mean[0]:.4f} ± {sigma[0]:.4f} px, y {mean[1]:.4f} ± {sigma[1]:.4f} px'
                )
    except NoCentroidsError as error:
        raise StationsError(str(error)) from None
    except OSError as error:
        raise StationsError(f'cannot write {path}: {error.strerror}') from None


def _visits(
    arguments: argparse.Namespace,
    quantities: Sequence[Quantity],
    done: int,
    *,
    measured: bool,
) -> Iterator[list[float]]:
    """Ask for one station after the other; yield where each is, in the units of the file."""
    steps = [getattr(arguments, quantity.name) for quantity in quantities]
    if any(each is not None for each in steps) and not measured:
        if any(each is None for each in steps):
            words = ' and '.join(f'--{quantity.name}' for quantity in quantities)
            raise StationsError(f'give {words}, or neither to be asked each time')
        grid = list(product(*steps))
        for index, settings in enumerate(grid[done:], start=done + 1):
            words = ', '.join(
                f'{quantity.name} to {value:g} {quantity.unit}'
                for quantity, value in zip(quantities, settings)
            )
            if _ask(f'station {index} of {len(grid)}: {words}; Enter when it stands, q ends: '):
                return
            yield list(settings)
        return
    names = ' and '.join(f'{quantity.name} ({quantity.unit})' for quantity in quantities)
    while True:
        if measured:
            if _ask(f'station {done + 1}: Enter when it stands, q ends: '):
                return
            done += 1
            yield []
            continue
        answer = _ask(f'station {done + 1}: {names} where it stands, Enter alone ends: ')
        if answer in ('', 'q'):
            return
        try:
            typed = [float(word) for word in answer.replace(',', ' ').split()]
        except ValueError:
            typed = []
        if len(typed) == len(quantities) and np.isfinite(typed).all():
            done += 1
            yield typed
        else:
            print(f'{answer!r} is not {len(quantities)} number(s): {names}')


def _ask(question: str) -> str:
    """Return what was typed; an input that has ended ends the measuring as q does."""
    try:
        return input(question).strip()
    except EOFError:
        return 'q'


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
            f'{word} must be {LEAST_COUNT} or more: fewer do not tell their own scatter'
        )
    return int(word)

"""Measurements at known stations, from a CSV file."""

from __future__ import annotations

from collections.abc import Sequence
import csv
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray

PIXELS = ('x', 'y')
SIGMAS = ('sigma_x', 'sigma_y')


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
        If the file is missing, lacks a column, or holds what is no number.

    """
    try:
        text = path.read_text(encoding='utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else 'it is no text'
        raise StationsError(f'cannot read the measurements {path}: {reason}') from None
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

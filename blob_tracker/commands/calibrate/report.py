"""How a calibration tells what it found."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
import sys

from blob_tracker.commands.exit_code import UsageError
from rich.console import Console
from rich.table import Table

Row = tuple[str, str, str, str]
LENGTH_SIGMA = 1e-3  # m: of a tape measure
WORTHLESS = 0.1  # of the focal length: a data sheet knows it better


def results_table(title: str, rows: Sequence[Row]) -> Table:
    """
    Return the table of a calibration's results.

    Parameters
    ----------
    title : str
        What was calibrated.
    rows : sequence of (str, str, str, str)
        Quantity, value, standard deviation, unit.

    """
    table = Table(title=title, min_width=60)
    table.add_column('quantity')
    table.add_column('value', justify='right')
    table.add_column('sigma', justify='right')
    table.add_column('unit')
    for row in rows:
        table.add_row(*row)
    return table


def row(quantity: str, value: float, sigma: float | None, unit: str) -> Row:
    """Return a row with as many digits as the standard deviation leaves a meaning."""
    if sigma is None or not sigma > 0.0:
        return quantity, f'{value:.4g}', 'not fitted' if sigma == 0.0 else '', unit
    digits = max(0, 1 - int(f'{sigma:e}'.partition('e')[2]))
    return quantity, f'{value:.{digits}f}', f'{sigma:.{digits}f}', unit


def tell_of(console: Console, path: Path) -> None:
    """Say that a file is written, and that one of its name is replaced."""
    console.print(f'{path}{" (replaced)" if path.exists() else ""}', markup=False, soft_wrap=True)


def warn(sentence: str) -> None:
    """Say what ought to be known, beside the results."""
    print(sentence, file=sys.stderr)


def picture_size(words: str) -> tuple[int, int]:
    """Return width and height of an option such as 640x480."""
    width, separator, height = words.lower().partition('x')
    if not (separator and width.isdigit() and height.isdigit() and int(width) * int(height)):
        raise argparse.ArgumentTypeError(f"'{words}' is not WIDTHxHEIGHT, 640x480 say")
    return int(width), int(height)


def length_of(
    option: str, form: str, words: Sequence[str] | None
) -> tuple[str, str, float, float] | None:
    """Return two names, what is between them and its standard deviation, m."""
    if words is None:
        return None
    try:
        one, other, *numbers = words
        length, sigma = (*map(float, numbers), LENGTH_SIGMA)[:2]
        if len(numbers) not in (1, 2) or not (isfinite(length) and isfinite(sigma)):
            raise ValueError
    except ValueError:
        raise UsageError(f'{option} {" ".join(words)}: it must be {form}') from None
    return one, other, length, sigma

"""How a calibration tells what it found."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from rich.console import Console
from rich.table import Table

Row = tuple[str, str, str, str]
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


class UsageError(ValueError):
    """An option that is wrong whatever the source holds; the message says what would be right."""


def check_out(out: Path, suffix: str, *inputs: Path | None) -> None:
    """
    Refuse a file that results should not go to.

    Parameters
    ----------
    out : Path
        The file.
    suffix : str
        That of the picture which is written beside it; '' where that has another name anyway.
    inputs : Path or None
        What is read, and must not be lost.

    Raises
    ------
    UsageError
        It is the picture's or an input's name, or there is no such folder.

    """
    if not out.parent.is_dir():
        raise UsageError(f'--out {out}: {out.parent} is not a folder; make it first')
    if suffix and out.suffix.lower() == suffix:
        yaml = out.with_suffix('.yaml')
        raise UsageError(
            f'--out {out} is the name of the picture beside it; name the file, {yaml} say'
        )
    for path in inputs:
        if path is not None and path.resolve() == out.resolve():
            raise UsageError(f'--out {out} is what is read; give it another name')


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

"""The numbers that the thesis prints, kept digit for digit as data with their table and page."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import yaml


@dataclass(frozen=True)
class Statement:
    """
    A number that the text gives, where a figure can only be looked at.

    Parameters
    ----------
    page : int
        Where it stands.
    says : str
        What it says, in other words.
    value : str
        The number, with the digits printed.

    """

    page: int
    says: str
    value: str


@dataclass(frozen=True)
class Printed:
    """
    A table of the thesis as it is printed, or what its text says about a figure.

    Parameters
    ----------
    source : str
        Table or figure, and page.
    columns : tuple of str
        Headings with units; empty for a figure.
    rows : tuple of tuple of str
        The numbers, with the digits printed.
    statements : dict of Statement
        What the text says about it, by a short name.

    """

    source: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    statements: dict[str, Statement]


def load(name: str) -> Printed:
    """
    Return what is printed.

    Parameters
    ----------
    name : str
        Of the file beside this one, without its ending: `table_3_3`, `figure_3_1`.

    Raises
    ------
    ValueError
        If the file holds a number that is not in quotes (its digits would be lost), or a row
        that does not fit the headings.

    """
    text = (files('blob_tracker.studies.printed') / f'{name}.yaml').read_text(encoding='utf-8')
    content: dict[str, Any] = yaml.safe_load(text)
    columns = tuple(content.get('columns', ()))
    rows = tuple(tuple(row) for row in content.get('rows', ()))
    statements = {
        key: Statement(**entry) for key, entry in content.get('statements', {}).items()
    }
    for row in rows:
        if len(row) != len(columns):
            raise ValueError(f'{name}: a row of {len(row)} numbers under {len(columns)} headings')
    cells = [cell for row in rows for cell in row]
    for value in cells + [statement.value for statement in statements.values()]:
        if not isinstance(value, str):
            raise ValueError(f'{name}: {value} must be in quotes, or its digits are lost')
    return Printed(content['source'], columns, rows, statements)


def unit(value: str) -> float:
    """Return what one step of the last printed digit is worth."""
    return 10.0 ** -len(value.partition('.')[2])


def units_off(value: float, printed: str) -> int:
    """
    Return by how many units of the last digit a value, rounded alike, is above what is printed.

    The sign of a printed zero ('-0.000000') means nothing.
    """
    digits = len(printed.partition('.')[2])
    return round((float(f'{value:.{digits}f}') - float(printed)) / unit(printed))

"""
What a commit did in these situations, kept beside the code as a table of figures.

Every run writes such a table to its folder; the baseline is one of them.
"""

from __future__ import annotations

from collections.abc import Sequence
import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from benchmarks.world.judge import Row

FILE = Path(__file__).with_name('baseline.csv')
NAMES = tuple(each.name for each in fields(Row) if each.name != 'distances')
TEXTS = ('kind', 'strength', 'said', 'verdict')
WHOLE = ('number', 'lit', 'bearings')


@dataclass(frozen=True)
class Baseline:
    """
    The rows of a commit.

    Parameters
    ----------
    commit : str
        Its abbreviated name.
    rows : dict
        By kind and strength; they have no `distances`.

    """

    commit: str
    rows: dict[tuple[str, str], Row]


def read(path: Path = FILE) -> Baseline:
    """Return what the file holds."""
    with path.open(newline='') as file:
        lines = list(csv.DictReader(file))
    rows = [Row(**{name: _value(name, line[name]) for name in NAMES}) for line in lines]
    commits = {line['commit'] for line in lines}
    return Baseline(' '.join(sorted(commits)), {(row.kind, row.strength): row for row in rows})


def write(path: Path, rows: Sequence[Row], commit: str) -> None:
    """Write the rows as those of a commit."""
    with path.open('w', newline='') as file:
        table = csv.DictWriter(file, ['commit', *NAMES], lineterminator='\n')
        table.writeheader()
        for row in rows:
            values = {name: value for name, value in asdict(row).items() if name in NAMES}
            table.writerow({'commit': commit} | {
                name: f'{value:.5g}' if isinstance(value, float) else value
                for name, value in values.items()
            })


def _value(name: str, text: str) -> Any:
    """Return the value of a field of `Row`."""
    if name in TEXTS:
        return text
    return int(text) if name in WHOLE else float(text)

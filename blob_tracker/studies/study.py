"""What a study is: the jobs that it consists of, and what is concluded from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from matplotlib.figure import Figure

# The parameters of a job and what it found: of what JSON can hold, as both are kept on disk.
Case = dict[str, Any]
Measured = dict[str, Any]
Cell = float | int | str | None


@dataclass(frozen=True)
class Table:
    """
    Numbers that are read.

    Parameters
    ----------
    name : str
        Of its CSV file, without the ending.
    title : str
        Of which table of the thesis, and of what.
    columns : sequence of str
        Headings, each with its unit.
    rows : sequence of sequence
        One cell for each heading; None if there is nothing. What the thesis prints stands
        beside ours, and the difference beside both.

    """

    name: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(
                    f'{self.name}: a row of {len(row)} cells under {len(self.columns)} headings'
                )


@dataclass(frozen=True)
class Check:
    """
    Something that the study was to show.

    Parameters
    ----------
    what : str
        In words.
    asked, found : str
        The demand and the result, with units.
    met : bool
        Whether the one meets the other.

    """

    what: str
    asked: str
    found: str
    met: bool


@dataclass(frozen=True)
class Findings:
    """
    What came of a study.

    Parameters
    ----------
    shows : str
        A sentence or three on what it shows, with the numbers that decide.
    agreement : str
        How closely the thesis is reproduced, in half a line; empty if it prints nothing.
    tables : sequence of Table
        All the data.
    figures : dict of Figure
        By name, each with its axes labelled.
    checks : sequence of Check
        What was to be shown.

    """

    shows: str
    agreement: str = ''
    tables: Sequence[Table] = ()
    figures: dict[str, Figure] = field(default_factory=dict)
    checks: Sequence[Check] = ()


@dataclass(frozen=True)
class Study:
    """
    One table or figure of the thesis done again, or a question beyond it.

    Parameters
    ----------
    name : str
        What is typed to run it.
    title : str
        What it is about, in half a line.
    source : str
        Which tables, figures or sections of the thesis, with their pages.
    cases : callable
        From `quick` to the jobs, each of a second or so: they are spread over processes.
    measure : callable
        Does one job: a function of a module, which gets all, also its seed, from the case.
    conclude : callable
        From all cases with what was measured, in their order, to the findings.

    """

    name: str
    title: str
    source: str
    cases: Callable[[bool], Sequence[Case]]
    measure: Callable[[Case], Measured]
    conclude: Callable[[Sequence[tuple[Case, Measured]]], Findings]

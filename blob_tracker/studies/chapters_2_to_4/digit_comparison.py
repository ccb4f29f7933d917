"""What the thesis prints beside what comes out, digit by digit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

from blob_tracker.studies.axes import COLOURS, legend_below, new_axes
from blob_tracker.studies.printed import Printed, unit, units_off
from blob_tracker.studies.study import Case, Cell, Measured, Table
from matplotlib.figure import Figure
import numpy as np

MEAN_OF_NORMAL = math.sqrt(2.0 / math.pi)  # the mean |error| of a normal one, in its sigma
Results = Sequence[tuple[Case, Measured]]


@dataclass(frozen=True)
class DigitComparison:
    """
    A printed table beside ours.

    Parameters
    ----------
    table : Table
        Both, and the differences.
    off : (rows, columns) array of int
        By how many units of the last printed digit ours is above.
    edge : float
        The farthest that a number which differs lies from where it would be rounded to what is
        printed, units of the last digit.

    """

    table: Table
    off: np.ndarray
    edge: float

    @property
    def same(self) -> int:
        """Numbers that agree in every printed digit."""
        return int((self.off == 0).sum())

    @property
    def one_off(self) -> int:
        """Numbers whose last digit is one off."""
        return int((np.abs(self.off) == 1).sum())

    @property
    def rows_same(self) -> int:
        """Rows that agree in every printed digit."""
        return int((self.off == 0).all(axis=1).sum())

    def sentence(self) -> str:
        """Return how closely it agrees."""
        count, rows = self.off.size, self.off.shape[0]
        if self.same == count:
            return f'{rows} of {rows} rows agree in every printed digit'
        if self.same + self.one_off == count:
            return (
                f'{self.same} of {count} numbers as printed, the others one unit of the last '
                'digit off'
            )
        return (
            f'{self.same} of {count} numbers as printed, {self.one_off} one unit of the last '
            f'digit off, {count - self.same - self.one_off} by more'
        )


def compare_digits(
    name: str, title: str, printed: Printed, keys: int, found: Sequence[Sequence[float]]
) -> DigitComparison:
    """
    Return a printed table beside ours.

    Parameters
    ----------
    name, title : str
        Of the table that is made.
    printed : Printed
        The table of the thesis.
    keys : int
        Its first columns, which say what the row is about.
    found : sequence of sequence of float
        Our numbers for the other columns, a row for each of its rows.

    """
    columns = list(printed.columns[:keys])
    for heading in printed.columns[keys:]:
        columns += [heading, 'printed', 'difference']
    cells: list[list[Cell]] = []
    edge = 0.0
    off = np.zeros((len(printed.rows), len(printed.columns) - keys), dtype=int)
    for n, (row, values) in enumerate(zip(printed.rows, found)):
        line: list[Cell] = list(row[:keys])
        for k, (value, digits) in enumerate(zip(values, row[keys:])):
            off[n, k] = units_off(value, digits)
            if off[n, k]:
                edge = max(edge, abs(value - float(digits)) / unit(digits) - 0.5)
            line += [value, digits, value - float(digits)]
        cells.append(line)
    return DigitComparison(Table(name, title, columns, cells), off, edge)


def draw_errors(
    printed: Printed,
    found: Sequence[Sequence[float]],
    bounds: Sequence[float] | None,
    least: float,
    bound_label: str,
) -> Figure:
    """
    Draw mean and largest error against s, a curve for each window, the printed ones as rings.

    Parameters
    ----------
    printed : Printed
        Columns: window, s, least, mean, variance and largest error, and maybe more.
    found : sequence of sequence of float
        Ours, from the least error on.
    bounds : sequence of float or None
        The Cramer-Rao bound on the mean error of each row, px, where there is noise.
    least : float
        px: what is smaller is drawn here.
    bound_label : str
        What the bound is of.

    """
    figure, panels = new_axes(2)
    sizes = list(dict.fromkeys(row[0] for row in printed.rows))
    for axes, column, name in zip(panels, (1, 3), ('mean |error|, px', 'largest |error|, px')):
        for size, colour in zip(sizes, COLOURS):
            chosen = [k for k, row in enumerate(printed.rows) if row[0] == size]
            s = [float(printed.rows[k][1]) for k in chosen]
            ours = [max(found[k][column], least) for k in chosen]
            # A printed zero has no place on a logarithmic axis.
            theirs = [float(printed.rows[k][2 + column]) or math.nan for k in chosen]
            axes.plot(s, ours, color=colour, linewidth=1.2, label=f'window {size} px')
            axes.plot(s, theirs, 'o', color=colour, fillstyle='none', markersize=7)
            if bounds is not None and column == 1:
                axes.plot(s, [bounds[k] for k in chosen], '--', color=colour, linewidth=0.8)
        axes.set(xlabel='s, px', ylabel=name, xscale='log', yscale='log')
        axes.set_xticks([1, 3, 5, 7, 10, 15], labels=['1', '3', '5', '7', '10', '15'])
        axes.minorticks_off()
    panels[0].plot([], [], 'o', color='black', fillstyle='none', label=printed.source)
    if bounds is not None:
        panels[0].plot([], [], '--', color='black', linewidth=0.8, label=bound_label)
    legend_below(figure, panels[0])
    return figure

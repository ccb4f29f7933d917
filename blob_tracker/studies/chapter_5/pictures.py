"""The plots of chapter 5: spreads beside printed values, and the places of a sequence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from blob_tracker.studies.axes import COLOURS, GOAL, REACHED
from blob_tracker.studies.study import Cell
from matplotlib.figure import Figure
import numpy as np

MARKERS = ('o', 's', '^', 'D', 'v', 'P', 'x')
THIN: dict[str, Any] = {'linewidth': 0.4, 'color': '#cccccc'}


def draw_spread(title: str, rows: Sequence[Sequence[Cell]], axis: str) -> Figure:
    """Draw for each row of a table the spread of the variance over seeds, and the printed one."""
    figure = Figure(figsize=(7.5, 1.6 + 0.19 * len(rows)), layout='constrained')
    axes = figure.subplots()
    y = np.arange(len(rows))[::-1]

    def column(index: int) -> list[float]:
        return [float(str(row[index])) for row in rows]

    axes.hlines(y, column(14), column(15), color=COLOURS[4], linewidth=4,
                label='ours, 5 to 95 % of the seeds')
    axes.plot(column(12), y, 'o', color=COLOURS[0], markersize=4, label='ours, median')
    axes.plot(column(11), y, 'x', color=COLOURS[1], markersize=6, markeredgewidth=1.6,
              label='printed')
    axes.plot(column(22), y, '|', color=COLOURS[6], markersize=8,
              label='Cramer-Rao bound and caliper')
    axes.set_yticks(y, [_label(row) for row in rows], fontsize=7)
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.set_xscale('log')
    axes.set_xlabel(axis)
    axes.grid(True, axis='x', **THIN)
    axes.set_axisbelow(True)
    figure.suptitle(title, fontsize=10)
    figure.legend(loc='outside lower center', ncols=4, fontsize=8)
    return figure


def _label(row: Sequence[Cell]) -> str:
    """Name a row of a table."""
    method = {'multi_gaussian_simplex': 'simplex', 'multi_gaussian_lm': 'LM'}.get(str(row[4]), '')
    words = [f'{row[0]} px', str(row[1]) if row[1] != 'Least Squares' else '', method, str(row[2])]
    if str(row[4]) != 'centroid':
        words.append(str(row[3]))
    return ', '.join(word for word in words if word)


def draw_places(
    title: str,
    curves: dict[str, list[float | None]],
    truth: Sequence[float],
    limits: dict[str, float],
) -> Figure:
    """Draw the places of one sequence against the truth, and below them their errors."""
    figure = Figure(figsize=(7.5, 6.0), layout='constrained')
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    places = np.asarray(truth) - truth[0]
    upper.plot(places, places, color='#888888', linewidth=1.0, label='true')
    for index, (name, values) in enumerate(curves.items()):
        found = np.array([np.nan if value is None else value for value in values])
        error = found - np.asarray(truth)
        about = error - np.nanmean(error)
        style = {
            'color': COLOURS[index % 6], 'marker': MARKERS[index % 7], 'linewidth': 1.0,
            # Curves that lie on each other must be seen: the first ones are large and hollow.
            'markersize': 8 if len(curves) > 2 and index < 2 else 4,
            'fillstyle': 'none' if len(curves) > 2 and index < 2 else 'full',
        }
        upper.plot(places, places + about, label=_name(name), **style)
        lower.plot(places, about, **style)
    lower.axhspan(-limits['single'], limits['single'], color='#bbbbbb',
                  label='+- Cramer-Rao bound, one look')
    for level in (-GOAL, GOAL):
        lower.axhline(level, color='#000000', linestyle=':', linewidth=0.8,
                      label=f'+-{GOAL:g} px' if level > 0 else None)
    for level in (-REACHED, REACHED):
        lower.axhline(level, color='#000000', linestyle='--', linewidth=0.8,
                      label=f'+-{REACHED:g} px (the thesis)' if level > 0 else None)
    upper.set_ylabel('displacement found, px')
    lower.set_ylabel('error less its mean, px')
    lower.set_xlabel('true displacement of the target, px')
    for axes in (upper, lower):
        axes.grid(True, **THIN)
    upper.legend(fontsize=8)
    lower.legend(fontsize=7, ncols=3, loc='best')
    figure.suptitle(title, fontsize=10)
    return figure


def _name(key: str) -> str:
    """Name a curve by its method, looks and window."""
    words = key.split()
    looks = {'single': 'one look', 'multi': 'mean of five'}[words[-1]]
    return f'{words[1]}, {looks}' + (', whole crop' if words[0] == 'whole' else '')

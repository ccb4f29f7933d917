"""The plots of the default pipeline on the sequences of chapter 5."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from blob_tracker.studies.axes import COLOURS, REACHED
from blob_tracker.studies.chapter_5.pictures import MARKERS, THIN
from blob_tracker.studies.printed import load
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray


def draw_errors(
    errors: Mapping[tuple[str, str], NDArray[np.float64]],
    limit: float,
    flat: float,
    floor: float,
    goal: float,
) -> Figure:
    """Draw how many errors are below each size."""
    figure = Figure(figsize=(7.5, 4.8), layout='constrained')
    axes = figure.subplots()
    ways = list(dict.fromkeys(way for way, _ in errors))
    for (way, looks), values in errors.items():
        size = np.sort(np.abs(values))
        axes.plot(
            size, np.arange(1, len(size) + 1) / len(size), color=COLOURS[ways.index(way)],
            linestyle='-' if looks == 'single' else ':',
            label=f'{way}, {"one look" if looks == "single" else "five looks"}',
        )
    axes.axvline(limit, color='#000000', linewidth=1.0,
                 label='Cramer-Rao bound, lit minus unlit')
    axes.axvline(flat, color='#000000', linestyle=':', linewidth=1.0,
                 label='the same, background known')
    axes.axvline(floor, color='#888888', linewidth=1.0,
                 label='that of lit minus unlit, line jitter')
    axes.axvline(goal, color='#000000', linestyle='-.', linewidth=1.0, label=f'goal, {goal} px')
    axes.axvline(REACHED, color='#000000', linestyle='--', linewidth=1.0,
                 label=f'the thesis, {REACHED:g} px')
    axes.set_xscale('log')
    axes.set_xlim(1e-4, 2.0)
    axes.set_xlabel('error of a place against the truth, px')
    axes.set_ylabel('part of the places below it')
    axes.grid(True, **THIN)
    figure.legend(loc='outside lower center', ncols=3, fontsize=7.5)
    figure.suptitle(
        'Default pipeline: absolute errors, active target, all steps\n'
        '(bounds of one look; defects removed: but for the straight line through the jitter)',
        fontsize=10,
    )
    return figure


def draw_steps(
    steps: Mapping[tuple[str, str], Sequence[float]],
    names: Sequence[str],
    floors: Mapping[str, float],
) -> Figure:
    """Draw the variance of the steps' errors beside the printed ones of Table 5.7."""
    figure = Figure(figsize=(7.5, 4.5), layout='constrained')
    panels = figure.subplots(1, 2, sharey=True)
    printed = load('table_5_7').rows
    x = np.arange(len(names))
    for axes, looks in zip(panels, ('single', 'multi')):
        for index, (key, values) in enumerate(steps.items()):
            if key[1] == looks:
                axes.plot(x, values, color=COLOURS[index // 2], marker=MARKERS[index // 2],
                          label=key[0])
        for row in printed:
            if row[2] == looks and row[1] == 'Shio & Otsu':
                axes.plot([names.index(row[0])], [float(row[4])], 'x', color=COLOURS[6],
                          markersize=8, label='printed, Table 5.7, with those of the stage'
                          if row[0] == names[0] else None)
        axes.axhline(floors[looks], color='#888888', linewidth=1.0,
                     label='bound, lit minus unlit, and line jitter')
        axes.set_xticks(x, [f'{name} px' for name in names])
        axes.set_xlabel(f'step, {"one look" if looks == "single" else "five looks"}')
        axes.set_yscale('log')
        axes.grid(True, **THIN)
    panels[0].set_ylabel("variance of the steps' errors, px$^2$")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=3, fontsize=8)
    figure.suptitle(
        "Steps' errors of the default pipeline, without the stage's, and the thesis' steps, "
        'active target', fontsize=10,
    )
    return figure

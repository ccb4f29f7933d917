"""The plots of the causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from blob_tracker.studies.axes import COLOURS, GOAL, REACHED
from blob_tracker.studies.chapter_5.pictures import MARKERS, THIN
from matplotlib.figure import Figure
import numpy as np

LEAST = 3e-4  # px: what is less is drawn there
TITLES = {
    'noise': 'noise', 'per_line': 'jitter of each line', 'per_frame': 'jitter of each frame',
    'caliper': 'stage', 'turn': 'turn of the camera',
}


def draw_causes(
    target: str,
    causes: Sequence[str],
    locators: Sequence[str],
    table: Mapping[tuple[str, str, str], Mapping[str, float]],
    limit: float,
) -> Figure:
    """Draw the rms less the offset for each cause, a mark for each locator."""
    figure = Figure(figsize=(8, 6.2), layout='constrained')
    axes = figure.subplots()
    y = np.arange(len(causes))[::-1].astype(float)
    for index, name in enumerate(locators):
        values = [
            max(table[target, cause, f'{name}|single']['apart'], LEAST) for cause in causes
        ]
        axes.plot(
            values, y + 0.06 * (len(locators) / 2 - index), marker=MARKERS[index % 7],
            color=COLOURS[index % 7], linestyle='none', markersize=5, label=name,
            fillstyle='none' if index >= 7 else 'full',
        )
    axes.axvline(limit, color='#000000', linewidth=1.0, label='Cramer-Rao bound, noise 1 DN')
    axes.axvline(GOAL, color='#000000', linestyle=':', linewidth=1.0, label=f'goal, {GOAL:g} px')
    axes.axvline(REACHED, color='#000000', linestyle='--', linewidth=1.0, label=f'{REACHED:g} px')
    axes.set_yticks(y, causes, fontsize=8)
    axes.set_xscale('log')
    axes.set_xlim(0.8 * LEAST, 0.6)
    axes.set_xlabel('rms error of a place less the common offset, one look, px')
    axes.grid(True, **THIN)
    axes.set_axisbelow(True)
    figure.suptitle(f'Causes, {target} target, steps of 0.05 px', fontsize=10)
    figure.legend(loc='outside lower center', ncols=3, fontsize=7)
    return figure


def draw_sizes(
    curves: Mapping[str, tuple[list[float], list[float], list[float]]],
    units: Mapping[str, str],
    level: float,
    limit: float,
) -> Figure:
    """Draw the worst of eleven places against the size of each defect."""
    figure = Figure(figsize=(9, 3.6), layout='constrained')
    panels = figure.subplots(1, len(curves), sharey=True)
    for axes, (name, (sizes, worst, centroid)) in zip(panels, curves.items()):
        axes.plot(sizes, worst, 'o-', color=COLOURS[0], label='three Gaussians, LM')
        axes.plot(sizes, centroid, 's--', color=COLOURS[1], label='centroid, extended histogram')
        axes.axhline(level, color='#000000', linestyle='--', linewidth=0.8, label='0.25 px')
        axes.axhline(limit, color='#000000', linewidth=0.8,
                     label='Cramer-Rao bound (rms), noise 1 DN')
        axes.set_xscale('log')
        axes.set_yscale('log')
        axes.set_xticks(sizes, [f'{size:g}' for size in sizes])
        axes.minorticks_off()
        axes.set_xlabel(f'{TITLES[name]}, {units[name]}', fontsize=8)
        axes.tick_params(labelsize=7)
        axes.grid(True, **THIN)
    panels[0].set_ylabel('worst of eleven places, median, px', fontsize=8)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=4, fontsize=8)
    return figure

"""Axes of one look for every figure of the studies."""

from __future__ import annotations

from blob_tracker.studies.printed import load
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Okabe and Ito's colours, which the colour-blind can tell apart; their yellow is too pale here.
COLOURS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#56B4E9', '#E69F00', '#000000')
_RESULTS = load('results_5').statements
GOAL = float(_RESULTS['goal'].value)  # px: what the thesis is after (page 13)
REACHED = float(_RESULTS['multi_gaussian'].value)  # px: where it ends (page 117)


def new_axes(panels: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure with so many axes side by side."""
    figure = Figure(figsize=(7.0 if panels == 1 else 9.5, 4.5), dpi=100, layout='constrained')
    axes = [figure.add_subplot(1, panels, k + 1) for k in range(panels)]
    for one in axes:
        one.grid(linewidth=0.4, alpha=0.5)
    return figure, axes


def legend_below(figure: Figure, axes: Axes, columns: int = 4) -> None:
    """Put the legend of the axes under the figure, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc='outside lower center', ncols=columns, fontsize='small'
    )

"""The plots of the trailing edge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from blob_tracker.studies.axes import COLOURS
from blob_tracker.studies.chapter_5.pictures import MARKERS, THIN
from blob_tracker.studies.study import Cell
from matplotlib.figure import Figure
import numpy as np


def draw_row(row: Mapping[str, Sequence[float]], peaking: float, memory: float) -> Figure:
    """Draw a row as the light is, as the camera shows it, and as it is restored."""
    figure = Figure(figsize=(7.5, 4.5), layout='constrained')
    axes = figure.subplots()
    k = np.arange(len(row['seen']))
    restored, doubt = np.array(row['restored']), np.array(row['doubt'])
    axes.plot(k, row['light'], color='#888888', linewidth=3.0, alpha=0.6, label='light')
    axes.step(k, row['seen'], where='mid', color=COLOURS[0], label='as the camera shows it')
    known = doubt <= 0.5
    axes.plot(k[known], restored[known], 'o', color=COLOURS[2], markersize=4,
              label='restored, known to half a DN')
    axes.errorbar(k[~known], restored[~known], doubt[~known], fmt='s', color=COLOURS[1],
                  markersize=4, linewidth=1.0, label='restored, in doubt by the bar')
    axes.set_xlabel('pixel of the row')
    axes.set_ylabel('DN')
    axes.grid(True, **THIN)
    axes.legend(fontsize=8)
    figure.suptitle(
        f'A row behind a filter of peaking {peaking:g} and memory {memory:g} px', fontsize=10
    )
    return figure


def draw_removal(
    rows: Sequence[Sequence[Cell]],
    ways: Sequence[str],
    backgrounds: Sequence[float],
    amplitudes: Sequence[float],
) -> Figure:
    """Draw the rms error against the amplitude for each way."""
    figure = Figure(figsize=(8, 4.5), layout='constrained')
    panels = figure.subplots(1, len(backgrounds), sharey=True)
    for axes, background in zip(panels, backgrounds):
        for index, way in enumerate(ways):
            rms = {
                row[1]: float(str(row[5])) for row in rows
                if row[0] == background and row[2] == way
            }
            axes.plot(list(rms), list(rms.values()), color=COLOURS[index],
                      marker=MARKERS[index], label=way)
        limit = {row[1]: float(str(row[7])) for row in rows if row[0] == background}
        axes.plot(list(limit), list(limit.values()), color='#000000', linewidth=1.0,
                  label='Cramer-Rao bound, no filter')
        axes.set_xscale('log')
        axes.set_yscale('log')
        axes.set_xticks(amplitudes, [f'{amplitude:g}' for amplitude in amplitudes])
        axes.minorticks_off()
        axes.set_xlabel(f'amplitude ahead of the filter, DN, on {background:g} DN')
        axes.grid(True, **THIN)
    panels[0].set_ylabel('rms error of x, px')
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=3, fontsize=8)
    figure.suptitle('Small blobs behind the filter: located as they come, and restored',
                    fontsize=10)
    return figure

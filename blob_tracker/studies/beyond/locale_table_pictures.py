"""Figures of the study of locales as a table."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.studies.axes import COLOURS as OKABE_ITO, new_axes
from blob_tracker.studies.beyond.locale_table_measurements import METHODS
from blob_tracker.studies.study import Case, Measured
from matplotlib.figure import Figure
import numpy as np

COLOURS = dict(zip((*METHODS, 'locales', 'bound'),
                   (OKABE_ITO[k] for k in (5, 3, 0, 2, 1, 6))))
MARKERS = dict(zip(METHODS, 'ovs^'))


def draw_pictures(pictures: Sequence[tuple[Case, Measured]]) -> Figure:
    """Colour displacements by their locale: neighbours of one colour give one picture."""
    figure, panels = new_axes(len(pictures))
    for axes, (case, found) in zip(panels, pictures):
        axes.set(xlabel='displacement in x, px', ylabel='displacement in y, px')
        axes.grid(False)
        axes.locator_params(nbins=5)
        nodes, reach = case['nodes'], case['reach']
        # Numbers of neighbours are near one another: shuffled, so that their colours are not.
        shuffled = np.random.default_rng(0).permutation(found['count'])
        axes.imshow(
            shuffled[np.array(found['number'])].reshape(nodes, nodes), origin='lower',
            extent=(-reach, reach, -reach, reach), cmap='cividis', interpolation='nearest',
        )
        axes.set_title(
            f"A {case['amplitude']:g} DN, s {case['s']:g} px: {found['count']} locales\n"
            f'in {2 * reach:g} x {2 * reach:g} px', fontsize=10,
        )
    return figure


def draw_sizes(locales: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (axes, right) = new_axes(2)
    axes.set(xlabel='amplitude A, DN', ylabel='rms error in x, px')
    rows = [(case, found) for case, found in locales if case['s'] == 1.5]
    amplitudes = [case['amplitude'] for case, _ in rows]
    axes.loglog(amplitudes, [found['locale_rms'] for _, found in rows], 'D-',
                color=COLOURS['locales'], label='exact map of the locales')
    for method in METHODS:
        axes.loglog(amplitudes, [found[method]['rms'] or np.nan for _, found in rows],
                    MARKERS[method] + '-', color=COLOURS[method], label=method)
    axes.loglog(amplitudes, [found['bound'] for _, found in rows], '--', color=COLOURS['bound'],
                label='bound, variance 1/12')
    axes.set_title(
        's 1.5 px, no noise but the rounding;\nonly the exact map is told A and s', fontsize=10
    )
    axes.legend(fontsize=8)
    right.set(xlabel='amplitude A, DN', ylabel='half the extent of a locale in x, px')
    styles = zip(('o-', 'v-', 's-', '^-'), COLOURS.values(), (1.0, 1.5, 2.0, 3.0))
    for style, colour, s in styles:
        own = [(case['amplitude'], found) for case, found in locales if case['s'] == s]
        right.loglog(
            [amplitude for amplitude, _ in own], [found['locale_most'] for _, found in own],
            style, color=colour, label=f's {s:g} px',
        )
        right.loglog([amplitude for amplitude, _ in own],
                     [found['locale_rms'] * np.sqrt(3.0) for _, found in own], ':',
                     color=colour)
    right.set_title('widest locale (solid)\nand rms over places (dotted)', fontsize=10)
    right.legend(fontsize=8)
    return figure


def draw_snr(results: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (left, right) = new_axes(2)
    snr = [case['snr'] for case, _ in results]
    left.set(xlabel='peak SNR', ylabel='rms error, px')
    right.set(xlabel='peak SNR', ylabel='rms error / Cramer-Rao bound')
    for method in METHODS:
        rms = [found[method]['rms'] or np.nan for _, found in results]
        over = [each / found['bound'] for each, (_, found) in zip(rms, results)]
        left.loglog(snr, rms, MARKERS[method] + '-', color=COLOURS[method], label=method)
        right.semilogx(snr, over, MARKERS[method] + '-', color=COLOURS[method])
    left.loglog(snr, [found['bound'] for _, found in results], '--', color=COLOURS['bound'],
                label='Cramer-Rao bound')
    right.axhline(1.0, linestyle='--', color=COLOURS['bound'])
    left.legend(fontsize=8)
    return figure


def draw_phase(results: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (left, right) = new_axes(2)
    phase = [case['phase'] for case, _ in results]
    left.set(xlabel='sub-pixel phase in x, px', ylabel='mean error in x, px')
    right.set(xlabel='sub-pixel phase in x, px', ylabel='rms error, px')
    for method in METHODS:
        style = MARKERS[method] + '-'
        left.plot(phase, [found[method]['bias'] for _, found in results], style,
                  color=COLOURS[method], markersize=4)
        right.plot(phase, [found[method]['rms'] for _, found in results], style,
                   color=COLOURS[method], markersize=4, label=method)
    right.plot(phase, [found['bound'] for _, found in results], '--', color=COLOURS['bound'],
               label='Cramer-Rao bound')
    right.set_ylim(bottom=0.0)
    right.legend(fontsize=8)
    return figure

"""The figures as pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.accuracy import Bias, Row
from benchmarks.real_pixels import Row as RealRow
import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

matplotlib.use('Agg')
AXES = {
    'snr': 'peak SNR',
    'window': 'window, px',
    'sigma': 'sigma, px',
    'axis ratio': 'ratio of the axes',
    'texture': 'texture, rms over mean of the ambient light',
    'saturation': 'peak over full scale',
}
LINES = ('-', '--', '-.', ':')
MARKERS = 'osv^D<>pPX*hd'


def draw(
    folder: Path,
    rows: Sequence[Row],
    biases: Sequence[Bias],
    real: Sequence[RealRow],
    ours: Sequence[str],
) -> list[Path]:
    """Draw what there is into the folder and return the files."""
    drawn = []
    if rows:
        drawn += [_sweep(folder, sweep, label, rows, ours) for sweep, label in AXES.items()]
    if biases:
        drawn.append(_bias(folder, biases, ours))
    if real:
        drawn.append(_phase(folder, real, ours))
    return drawn


def _style(names: Sequence[str], ours: Sequence[str]) -> dict[str, dict[str, object]]:
    """Return a look for each contender: this project's in front and thick."""
    colours = matplotlib.colormaps['tab20'].colors
    return {
        name: {
            'color': colours[index % len(colours)],
            'linestyle': '-' if name in ours else LINES[1 + index % 3],
            'linewidth': 2.4 if name in ours else 1.3,
            'marker': MARKERS[index % len(MARKERS)],
            'markersize': 4,
            'zorder': 3 if name in ours else 2,
        }
        for index, name in enumerate(names)
    }


def _sweep(
    folder: Path, sweep: str, label: str, rows: Sequence[Row], ours: Sequence[str]
) -> Path:
    chosen = [row for row in rows if row.sweep == sweep]
    figure = Figure(figsize=(9.5, 5.5), layout='constrained')
    axes = figure.add_subplot()
    names = list(dict.fromkeys(row.contender for row in chosen))
    for name, style in _style(names, ours).items():
        mine = [row for row in chosen if row.contender == name]
        axes.plot([float(row.value) for row in mine], [row.ratio for row in mine], label=name,
                  **style)
    axes.axhline(1.0, color='black', linewidth=0.8)
    axes.set_yscale('log')
    axes.set_ylim(0.8, 40)
    axes.set_yticks([1, 2, 5, 10, 20], ['1', '2', '5', '10', '20'])
    if sweep in ('snr', 'sigma', 'saturation'):
        axes.set_xscale('log')
        ticks = [float(value) for value in dict.fromkeys(row.value for row in chosen)]
        axes.set_xticks(ticks, [f'{tick:g}' for tick in ticks])
        axes.xaxis.minorticks_off()
    axes.set_ylabel('rms error / Cramer-Rao bound')
    return _save(figure, axes, folder / f'accuracy_{sweep.replace(" ", "_")}.png', label)


def _bias(folder: Path, biases: Sequence[Bias], ours: Sequence[str]) -> Path:
    scenes = list(dict.fromkeys(bias.scene for bias in biases))
    names = list(dict.fromkeys(bias.contender for bias in biases))
    styles = _style(names, ours)
    figure = Figure(figsize=(5 * len(scenes) + 3, 5.5), layout='constrained')
    panels = figure.subplots(1, len(scenes), squeeze=False)[0]
    for axes, scene in zip(panels, scenes):
        for bias in biases:
            if bias.scene == scene:
                axes.plot(bias.phase, bias.mean, label=bias.contender, **styles[bias.contender])
        axes.set_title(f'{scene}, SNR 200')
        axes.set_yscale('symlog', linthresh=0.005)
        axes.set_ylim(-0.5, 0.5)
        axes.axhspan(-0.005, 0.005, color='grey', alpha=0.2)
        axes.set_ylabel('mean error, px (linear within +-0.005)')
        axes.set_xlabel('sub-pixel phase, px')
    return _save(figure, panels[-1], folder / 'bias.png', 'sub-pixel phase, px')


def _phase(folder: Path, real: Sequence[RealRow], ours: Sequence[str]) -> Path:
    kinds = list(dict.fromkeys(row.kind for row in real))
    styles = _style(list(dict.fromkeys(row.contender for row in real)), ours)
    figure = Figure(figsize=(6 * len(kinds) + 3, 5.5), layout='constrained')
    panels = figure.subplots(1, len(kinds), squeeze=False)[0]
    for axes, kind in zip(panels, kinds):
        for row in real:
            if row.kind == kind:
                axes.plot(row.phase, row.mean, label=row.contender, **styles[row.contender])
        axes.set_title(kind)
        axes.set_ylabel('mean residual, px')
        axes.set_xlabel('sub-pixel phase, px')
    return _save(figure, panels[-1], folder / 'real_phase.png', 'sub-pixel phase, px')


def _save(figure: Figure, axes: Axes, path: Path, label: str) -> Path:
    axes.set_xlabel(label)
    axes.grid(alpha=0.3)
    axes.legend(loc='center left', bbox_to_anchor=(1.01, 0.5), fontsize=8)
    figure.savefig(path, dpi=120)
    return path

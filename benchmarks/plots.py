"""The figures as pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.accuracy import Bias, Row
from benchmarks.ours import CHAMPION
from benchmarks.real_pixels import Row as RealRow
from benchmarks.report import Report
from benchmarks.tables import TITLES
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
LINES = ('--', '-.', ':')
MARKERS = 'osv^D<>pPX*hd'
OWN = ('#000000', '#c40000', '#0050c8', '#008c3a', '#9a00b4', '#d07800', '#00909c', '#7a5a00')
OTHER = ('#e377c2', '#7f7f7f', '#bcbd22', '#17becf', '#ff9896', '#98df8a', '#c5b0d5', '#c49c94')


def draw(folder: Path, report: Report, ours: Sequence[str]) -> list[Path]:
    """Draw what was measured into the folder and return the files; `ours` stand out."""
    drawn = []
    if report.accuracy:
        drawn += [
            _sweep(folder, sweep, label, report.accuracy, ours) for sweep, label in AXES.items()
        ]
    if report.bias:
        drawn.append(_bias(folder, report.bias, ours))
    if report.real:
        drawn.append(_phase(folder, report.real, ours))
    return drawn


def _style(names: Sequence[str], ours: Sequence[str]) -> dict[str, dict[str, object]]:
    """Return a look for each contender: this project's dark and thick, the champion on top."""
    styles: dict[str, dict[str, object]] = {}
    for index, name in enumerate(names):
        own = name in ours
        rank = sum((other in ours) == own for other in names[:index])
        palette = OWN if own else OTHER
        styles[name] = {
            'color': palette[rank % len(palette)],
            'linestyle': '-' if own else LINES[rank % len(LINES)],
            'linewidth': 2.2 if own else 1.4,
            'marker': MARKERS[index % len(MARKERS)],
            'markersize': 4.5,
            'zorder': 4 if name == CHAMPION else 3 if own else 2,
        }
    return styles


def _sweep(
    folder: Path, sweep: str, label: str, rows: Sequence[Row], ours: Sequence[str]
) -> Path:
    chosen = [row for row in rows if row.sweep == sweep]
    figure = Figure(figsize=(9.5, 5.5), layout='constrained')
    axes = figure.add_subplot()
    names = list(dict.fromkeys(row.contender for row in chosen))
    for name, style in _style(names, ours).items():
        mine = [row for row in chosen if row.contender == name]
        values = [float(row.value) for row in mine]
        axes.plot(values, [row.ratio for row in mine], label=name, **style)
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
    axes.set_title(TITLES[sweep])
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

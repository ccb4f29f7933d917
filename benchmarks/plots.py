"""The figures as pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.accuracy import Bias, Row
from benchmarks.detection import ASKED_SNR, OURS, Row as DetectionRow, share, SNRS
from benchmarks.ours import CHAMPION
from benchmarks.real_pixels import CORRECTED, Row as RealRow
from benchmarks.report import Report
from benchmarks.tables import TITLES
from benchmarks.world import baseline, plots as world_plots
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
FEWEST = 80  # blobs: 8 to a bin of the phase, below it the curves are noise
MARKERS = 'osv^D<>pPX*hd'
FRONT = {CHAMPION: '#000000', CORRECTED: '#ff5a00', OURS: '#000000'}  # what the figures are about
OWN = ('#c40000', '#0050c8', '#008c3a', '#9a00b4', '#d07800', '#00909c', '#7a5a00', '#b0006a')
OTHER = (
    *('#e377c2', '#7f7f7f', '#bcbd22', '#17becf', '#ff9896'),
    *('#98df8a', '#c5b0d5', '#c49c94', '#9edae5', '#f7b6d2'),
)


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
    if report.detection:
        drawn.append(_detection(folder, report.detection))
    if report.world:
        drawn += world_plots.draw(folder / 'world', report.world, baseline.read())
    return drawn


def _detection(folder: Path, rows: Sequence[DetectionRow]) -> Path:
    """Draw all contenders over all scenes, and ours on each scene, against the peak SNR."""
    figure = Figure(figsize=(15, 8.5), layout='constrained')
    upper, lower = figure.subplots(2, 1)
    names = list(dict.fromkeys(row.contender for row in rows))
    _detection_panel(upper, rows, names, lambda row: row.contender)
    upper.set_title('Lit frames found, all clutter scenes')
    ours = [row for row in rows if row.contender == OURS]
    scenes = list(dict.fromkeys(row.scene for row in ours))
    _detection_panel(lower, ours, scenes, lambda row: row.scene)
    lower.set_title(f'Lit frames found by {OURS}, scene by scene')
    path = folder / 'detection.png'
    figure.savefig(path, dpi=110)
    return path


def _detection_panel(
    axes: Axes, rows: Sequence[DetectionRow], names: Sequence[str],
    key: Callable[[DetectionRow], str],
) -> None:
    # Steps of equal width: the SNRs at which it is decided lie close together.
    steps = range(len(SNRS))
    for name, style in _style(names, [OURS]).items():
        mine = [row for row in rows if key(row) == name]
        shares = [100 * share([row for row in mine if row.snr == snr]) for snr in SNRS]
        axes.plot(steps, shares, label=name, **style)
    axes.axhline(99.9, color='black', linewidth=0.8)
    axes.axvline(SNRS.index(ASKED_SNR), color='black', linewidth=0.8, linestyle=':')
    axes.set_xticks(steps, [f'{snr:g}' for snr in SNRS])
    axes.set_xlabel('peak SNR')
    axes.set_ylabel('found, %')
    axes.set_ylim(-3, 103)
    axes.grid(alpha=0.3)
    axes.legend(loc='center left', bbox_to_anchor=(1.01, 0.5), fontsize=9)


def _style(names: Sequence[str], ours: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return a look for each contender: this project's dark and thick, FRONT on top."""
    styles: dict[str, dict[str, Any]] = {}
    for index, name in enumerate(names):
        own = name in ours
        rank = sum((other in ours) == own for other in names[:index])
        palette = OWN if own else OTHER
        styles[name] = {
            'color': FRONT.get(name, palette[rank % len(palette)]),
            'alpha': 1.0 if name in FRONT else 0.6,
            'linestyle': '-' if own else LINES[rank % len(LINES)],
            'linewidth': 2.6 if name in FRONT else 1.8 if own else 1.4,
            'marker': MARKERS[index % len(MARKERS)],
            'markersize': 4.5,
            'zorder': 4 if name in FRONT else 3 if own else 2,
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
    axes.set_xlabel(label)
    axes.grid(alpha=0.3)
    return _save(figure, axes, folder / f'accuracy_{sweep.replace(" ", "_")}.png')


def _bias(folder: Path, biases: Sequence[Bias], ours: Sequence[str]) -> Path:
    curves = [(bias.scene, bias.contender, bias.phase, bias.mean) for bias in biases]
    figure, panels = _against_phase(curves, ours)
    for axes in panels:
        axes.set_ylabel('mean error at SNR 200, px (linear within +-0.005)')
        axes.set_yscale('symlog', linthresh=0.005)
        axes.set_ylim(-0.5, 0.5)
        axes.axhspan(-0.005, 0.005, color='grey', alpha=0.2)
    return _save(figure, panels[-1], folder / 'bias.png')


def _phase(folder: Path, real: Sequence[RealRow], ours: Sequence[str]) -> Path:
    curves = [
        (row.kind, row.contender, row.phase, row.mean) for row in real if row.total >= FEWEST
    ]
    figure, panels = _against_phase(curves, ours)
    for axes in panels:
        axes.set_ylabel('mean residual, px')
    return _save(figure, panels[-1], folder / 'real_phase.png')


def _against_phase(
    curves: Sequence[tuple[str, str, list[float], list[float]]], ours: Sequence[str]
) -> tuple[Figure, list[Axes]]:
    """Draw (panel, contender, phase, mean) curves, a panel for each name."""
    titles = list(dict.fromkeys(title for title, *_ in curves))
    styles = _style(list(dict.fromkeys(name for _, name, *_ in curves)), ours)
    figure = Figure(figsize=(5 * len(titles) + 3, 5.5), layout='constrained')
    panels = list(figure.subplots(1, len(titles), squeeze=False)[0])
    for axes, title in zip(panels, titles):
        for panel, name, phase, mean in curves:
            if panel == title:
                axes.plot(phase, mean, label=name, **styles[name])
        axes.set_title(title)
        axes.set_xlabel('sub-pixel phase, px')
        axes.grid(alpha=0.3)
    return figure, panels


def _save(figure: Figure, axes: Axes, path: Path) -> Path:
    """Save the figure with the legend of all its panels beside the one that is given."""
    lines: dict[str, Any] = {}
    for panel in figure.axes:
        for line, label in zip(*panel.get_legend_handles_labels()):
            lines.setdefault(label, line)
    axes.legend(
        lines.values(), lines.keys(), loc='center left', bbox_to_anchor=(1.01, 0.5), fontsize=8
    )
    figure.savefig(path, dpi=120)
    return path

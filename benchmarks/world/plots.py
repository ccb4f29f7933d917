"""Each kind of trouble as a picture: how far bearings are off, in their own sigmas."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import re

from benchmarks.world.baseline import Baseline
from benchmarks.world.judge import FOUND, NEES, Row, SIGMAS
import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

matplotlib.use('Agg')
LEAST, MOST = 0.01, 3e3  # sigmas, the ends of the axis
TRUE = (NEES[0] / 2.0) ** 0.5, (NEES[1] / 2.0) ** 0.5
SPREAD = 0.22  # of a step, to either side
GOOD, BAD, QUIET, BEFORE = '#006d5b', '#c8102e', '#8a8a8a', '#e08a00'
# Bearings that lie as a true covariance has them: |e| / sigma of two axes is Rayleigh / sqrt 2.
FAR = SIGMAS / 2.0**0.5


def draw(folder: Path, rows: Sequence[Row], baseline: Baseline) -> list[Path]:
    """Draw a picture for each kind into the folder and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    return [
        _kind(folder, [row for row in rows if row.kind == kind], baseline)
        for kind in dict.fromkeys(row.kind for row in rows)
    ]


def _kind(folder: Path, rows: Sequence[Row], baseline: Baseline) -> Path:
    figure = Figure(figsize=(2.6 + 1.7 * len(rows), 6.0), layout='constrained')
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(5, 1))
    _distances(upper, rows, baseline)
    _found(lower, rows, baseline)
    kind = rows[0].kind
    upper.set_title(f'{rows[0].number}  {kind}')
    lower.set_xticks(range(len(rows)), [row.strength for row in rows])
    figure.legend(loc='outside lower center', ncols=3, fontsize=8, frameon=False)
    name = re.sub(r'[^a-z0-9]+', '_', kind.lower()).strip('_')
    path = folder / f'{rows[0].number:02d}_{name}.png'
    figure.savefig(path, dpi=110)
    return path


def _distances(axes: Axes, rows: Sequence[Row], baseline: Baseline) -> None:
    """Draw each bearing as a dot, and the roots of the mean squares of now and then."""
    axes.axhspan(*TRUE, color=GOOD, alpha=0.2, linewidth=0, label='covariance true enough')
    axes.axhline(FAR, color=BAD, linewidth=0.8, linestyle=':', label='5 sigma')
    random = np.random.default_rng(0)
    for step, row in enumerate(rows):
        sigmas = np.clip(row.distances, LEAST, MOST)
        at = step + random.uniform(-SPREAD, SPREAD, sigmas.size)
        axes.scatter(
            at, sigmas, s=7, alpha=0.35, linewidths=0, color=np.where(sigmas > FAR, BAD, GOOD)
        )
        if not sigmas.size:
            axes.text(step, 1.0, row.verdict, ha='center', va='center', color=QUIET)
    steps = np.arange(len(rows))
    now = np.array([row.nees for row in rows])
    then = np.array([_nees_before(row, baseline) for row in rows])
    for nees, colour, label, offset, marker in (
        (then, BEFORE, f'all of {baseline.commit}', 0.34, '<'),
        (now, 'black', 'all of this run', -0.34, '>'),
    ):
        axes.plot(
            steps + offset, np.clip(np.sqrt(nees / 2.0), LEAST, MOST), marker, color=colour,
            markersize=8, markeredgecolor='white', label=label,
        )
    axes.set_yscale('log')
    axes.set_ylim(LEAST, MOST)
    axes.set_xlim(-0.6, len(rows) - 0.4)
    axes.set_ylabel('error / own sigma, rms of x and y')
    axes.grid(axis='y', alpha=0.25)


def _found(axes: Axes, rows: Sequence[Row], baseline: Baseline) -> None:
    """Draw how many of the lit frames have a bearing, now and then."""
    steps = np.arange(len(rows))
    found = np.array([row.found for row in rows])
    was = np.array([
        baseline.rows[row.kind, row.strength].found
        if (row.kind, row.strength) in baseline.rows else np.nan for row in rows
    ])
    axes.bar(steps - 0.11, 100 * found, 0.2, color='black')
    axes.bar(steps + 0.11, 100 * was, 0.2, color=BEFORE)
    axes.axhline(100 * FOUND, color=GOOD, linewidth=0.8)
    axes.set_ylim(0, 105)
    axes.set_ylabel('found, %')


def _nees_before(row: Row, baseline: Baseline) -> float:
    was = baseline.rows.get((row.kind, row.strength))
    return float('nan') if was is None else was.nees

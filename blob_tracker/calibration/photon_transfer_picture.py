"""The transfer curve as a picture: variance over level, the line, and what is left."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

from blob_tracker.calibration.noise_line import NoiseLine
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

FITTED, LEFT_OUT, LINE = '#0050c8', '#9a9a9a', '#c40000'


def draw_noise_line(
    path: Path,
    line: NoiseLine,
    levels: NDArray[np.float64],
    variances: NDArray[np.float64],
    scatters: NDArray[np.float64],
    used: NDArray[np.bool_],
    *,
    title: str,
    label: str,
) -> None:
    """
    Draw the points, the line through them, and their residuals.

    Parameters
    ----------
    path : Path
        The PNG to write.
    line : NoiseLine
        Of `levels`.
    levels, variances, scatters : (n,) arrays
        DN, DN^2, and the variance of a variance over its square.
    used : (n,) bool array
        Points that the line was fitted to.
    title, label : str
        Above the picture, and of the axis of levels.

    """
    figure = Figure(figsize=(9.0, 8.0), layout='constrained')
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    sigmas = np.sqrt(scatters) * variances
    for each, colour, words in (
        (used, FITTED, 'fitted'), (~used, LEFT_OUT, 'left out')
    ):
        if each.any():
            upper.errorbar(
                levels[each], variances[each], sigmas[each], fmt='o', color=colour, label=words,
                markersize=6, capsize=3,
            )
    span = np.linspace(0.0, levels[used].max(), 200)
    height = line.foot + line.slope * span
    gain_sigma = sqrt(line.noise_covariance[0, 0])
    upper.plot(
        span, height, color=LINE,
        label=f'{line.foot:.3g} DN² + level × {line.slope:.4g} DN/e⁻\n'
              f'gain {line.gain:.4g} ± {gain_sigma:.2g} e⁻/DN',
    )
    upper.set_ylabel('temporal variance, DN²')
    upper.set_title(title)
    upper.legend(loc='upper left')
    expected = line.foot + line.slope * levels[used]
    lower.errorbar(
        levels[used],
        100.0 * (variances[used] / expected - 1.0),
        100.0 * np.sqrt(scatters[used]),
        fmt='o', color=FITTED, markersize=6, capsize=3,
    )
    lower.axhline(0.0, color=LINE)
    lower.set_ylabel('variance off the line, %')
    lower.set_xlabel(label)
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
        for text in (axes.xaxis.label, axes.yaxis.label, axes.title):
            text.set_fontsize(13)
        axes.tick_params(labelsize=11)
    figure.savefig(path, dpi=110)

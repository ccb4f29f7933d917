"""The residuals of a camera that was turned, over its picture and against the angles."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.turn import TurnCalibration
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

ARROW = 0.06  # of the width: the longest residual


def draw_turn(path: Path, pixels: NDArray[np.float64], result: TurnCalibration) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    pixels : (n, 2) array
        Where the target was, px.
    result : TurnCalibration
        The fit to them.

    """
    width, height = result.model.width, result.model.height
    figure = Figure(figsize=(12, 5.4), layout='constrained')
    left, right = figure.subplots(1, 2)
    longest = max(float(np.hypot(*result.residuals.T).max()), 1e-9)
    zoom = ARROW * width / longest
    left.quiver(
        *pixels.T, *result.residuals.T, angles='xy', scale_units='xy', scale=1.0 / zoom,
        color='#c0392b', width=0.004,
    )
    left.plot(*pixels.T, '.', color='#2c3e50', markersize=4, label='stations')
    left.plot(
        *result.model.matrix[:2, 2], '+', color='#2980b9', markersize=14, label='principal point'
    )
    left.set(
        title=f'Residuals, {zoom:.0f} times as long; the longest is {longest:.3f} px',
        xlabel='x (px)',
        ylabel='y (px)',
        xlim=(-0.5, width - 0.5),
        ylim=(height - 0.5, -0.5),  # y points down, as in the picture
        aspect='equal',
    )
    left.legend(loc='upper right')
    away = np.hypot(*(pixels - result.model.matrix[:2, 2]).T)
    for name, residual, mark in zip('xy', result.residuals.T, 'ox'):
        right.plot(away, residual, mark, label=name, markersize=5)
    right.axhline(0.0, color='grey', linewidth=0.8)
    right.set(
        title='A bow here is lens distortion that the model lacks',
        xlabel='distance from the principal point (px)',
        ylabel='measured - fitted (px)',
    )
    right.legend()
    figure.savefig(path, dpi=110)

"""A track as a picture: the path against the truth, and how the errors are spread."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

BREAK = 10.0  # usual steps, beyond which frames are missing and the path is not joined
LOCATED, TRUE = '#c0392b', '#2c3e50'


def draw_track(
    path: Path,
    located: NDArray[np.float64],
    covariances: NDArray[np.float64],
    true: NDArray[np.float64] | None,
    size: tuple[int, int],
    budget: float,
) -> None:
    """
    Write the picture of a track.

    Parameters
    ----------
    path : Path
        The PNG to write.
    located : (N, 2) array
        x, y of each location, px.
    covariances : (N, 2, 2) array
        Its covariance, px^2.
    true : (N, 2) array or None
        Where the light was, px; None on a real camera.
    size : (int, int)
        Width and height of the frame, px.
    budget : float
        The rms error that is allowed, px.

    """
    figure = Figure(figsize=(12, 5.4), layout='constrained')
    left, right = figure.subplots(1, 2)
    if true is not None:
        for number, part in enumerate(joined(true)):
            left.plot(
                *part.T, color=TRUE, linewidth=3, alpha=0.35,
                label='true path' if number == 0 else None,
            )
    left.plot(*located.T, '.', color=LOCATED, markersize=3, label='located')
    left.set(
        title=f'{len(located)} locations in the frame',
        xlabel='x (px)',
        ylabel='y (px)',
        xlim=(-0.5, size[0] - 0.5),
        ylim=(size[1] - 0.5, -0.5),  # y points down, as in the picture
        aspect='equal',
    )
    left.legend(loc='upper right')
    if true is None:
        steps = np.hypot(*np.diff(located, axis=0).T)
        right.hist(steps, bins=40, color=LOCATED, alpha=0.7)
        right.set(
            title='Step from one location to the next', xlabel='step (px)', ylabel='count'
        )
    else:
        _draw_errors(right, located - true, covariances, budget)
    figure.savefig(path, dpi=110)


def joined(path: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the parts of a path between which frames are missing."""
    steps = np.hypot(*np.diff(path, axis=0).T)
    usual = max(float(np.median(steps)), 1.0) if len(steps) else 1.0  # px
    return np.split(path, np.flatnonzero(steps > BREAK * usual) + 1)


def _draw_errors(
    axes: Axes,
    errors: NDArray[np.float64],
    covariances: NDArray[np.float64],
    budget: float,
) -> None:
    """Draw the histogram of both coordinates' errors beside what the covariance predicts."""
    values = errors.ravel()
    variances = np.diagonal(covariances, axis1=1, axis2=2).ravel()
    rms = np.sqrt(np.mean(values**2))
    reach = max(1.2 * budget, 4.0 * rms)
    bins = np.linspace(-reach, reach, 61).tolist()
    axes.hist(values, bins=bins, density=True, color=LOCATED, alpha=0.7, label='x and y errors')
    grid = np.linspace(-reach, reach, 400)
    predicted = np.exp(-(grid[:, None] ** 2) / (2 * variances)) / np.sqrt(2 * np.pi * variances)
    axes.plot(grid, predicted.mean(axis=1), color=TRUE, label='predicted by the covariances')
    for side in (-budget, budget):
        axes.axvline(side, color='grey', linestyle='--')
    axes.plot([], [], color='grey', linestyle='--', label=f'budget {budget:g} px rms')
    axes.set(
        title=f'Error: {rms:.4f} px rms, predicted {np.sqrt(variances.mean()):.4f} px',
        xlabel='located - true (px)',
        ylabel='density (1/px)',
    )
    axes.margins(y=0.3)  # room for the legend above the bars
    axes.legend(loc='upper right')

"""What a fit leaves of where a light is seen, over its standard deviations: parts of pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

WIDEST = 5.0  # standard deviations
BINS = 41


def draw_over(axes: Any, across: NDArray[np.float64], residuals: NDArray[np.float64]) -> None:
    """
    Draw residuals to the right and up over something.

    Parameters
    ----------
    axes : Axes
        Of the picture.
    across : (n,) array
        What they are drawn over.
    residuals : (n, 2) array
        To the right and up, over their standard deviations.

    """
    for name, each, colour in zip(('right', 'up'), residuals.T, ('#2980b9', '#c0392b')):
        axes.plot(across, each, '.', color=colour, markersize=3, label=name)
    axes.axhline(0.0, color='grey', linewidth=0.8)


def draw_spread(axes: Any, residuals: NDArray[np.float64]) -> None:
    """
    Draw how often residuals are how large, and how often they should be.

    Parameters
    ----------
    axes : Axes
        Of the picture.
    residuals : (n, 2) array
        Over their standard deviations.

    """
    edges = np.linspace(-WIDEST, WIDEST, BINS)
    axes.hist(residuals.ravel(), edges, density=True, color='#95a5a6')
    axes.plot(edges, np.exp(-0.5 * edges**2) / np.sqrt(2.0 * np.pi), 'k', linewidth=0.8)
    axes.set(
        title='All of them, and a Gaussian of 1', xlabel='standard deviations', ylabel='density'
    )

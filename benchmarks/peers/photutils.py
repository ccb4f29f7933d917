"""photutils: centre of mass and least-squares elliptical Gaussian (astropy project)."""

from __future__ import annotations

from collections.abc import Callable
import warnings

from benchmarks.contender import Contender
from benchmarks.windows import clipped, Positions, signal, signal_variance, Windows
import numpy as np
from numpy.typing import NDArray
from photutils.centroids import centroid_2dg, centroid_com

Centroid = Callable[..., NDArray[np.float64]]


def _each(centroid: Centroid, windows: Windows, **planes: NDArray[np.generic]) -> Positions:
    """Return what the function finds in each window; NaN where it gives up."""
    found = np.full((len(windows.lit), 2), np.nan)
    with warnings.catch_warnings():
        # It warns of fits that did not converge; the position it returns is what is judged.
        warnings.simplefilter('ignore')
        for index, data in enumerate(signal(windows)):
            plane = {name: stack[index] for name, stack in planes.items()}
            try:
                found[index] = centroid(data, **plane)
            except ValueError:
                continue
    return found[:, 0], found[:, 1]


def _com(windows: Windows) -> Positions:
    return _each(centroid_com, windows)


def _gaussian(windows: Windows) -> Positions:
    error = np.sqrt(signal_variance(windows))
    return _each(centroid_2dg, windows, error=error, mask=clipped(windows))


PEERS = (
    Contender(
        'photutils centroid_com',
        'background subtracted; no mask (worse)',
        _com,
        share=0.1,
    ),
    Contender(
        'photutils centroid_2dg',
        'background subtracted, clipped pixels masked, error = noise of each pixel',
        _gaussian,
        share=0.01,
    ),
)

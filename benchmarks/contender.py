"""A location method in the comparison, whoever wrote it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.windows import Positions, Windows
import numpy as np
from numpy.typing import NDArray

Covariances = NDArray[np.float64]


@dataclass(frozen=True)
class Contender:
    """
    One method with the setting that it is run at.

    Parameters
    ----------
    name : str
        As it stands in tables and plots.
    setting : str
        What it is given and told, in a line.
    locate : function
        Windows -> (x, y), (N,) px in window coordinates, NaN where it finds nothing.
    share : float
        Share of a scene's windows that it gets, by its pace; never another choice of windows.
    single : function or None
        Windows of one -> its own call for one window, where that is not `locate`.
    covariance : function or None
        Windows -> (N, 2, 2) px^2, where the method states one.

    """

    name: str
    setting: str
    locate: Callable[[Windows], Positions]
    share: float = 1.0
    single: Callable[[Windows], object] | None = None
    covariance: Callable[[Windows], Covariances] | None = None


SLOW = 0.05  # a share below it: milliseconds a window
SLOWEST = 0.005  # a share below it: tens of milliseconds


def count_for(contender: Contender, available: int) -> int:
    """Return how many of the available windows the contender gets: at least 20."""
    return min(available, max(20, round(available * contender.share)))


def inside(positions: Positions, shape: tuple[int, int]) -> Positions:
    """Return the positions with NaN where they are not finite or lie outside the window."""
    x, y = (np.asarray(axis, dtype=float) for axis in positions)
    height, width = shape
    with np.errstate(invalid='ignore'):
        good = (np.abs(x - (width - 1) / 2) <= width / 2) & (
            np.abs(y - (height - 1) / 2) <= height / 2
        )
    return np.where(good, x, np.nan), np.where(good, y, np.nan)

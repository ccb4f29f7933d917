"""The unlit pixels of a light's windows, and those that two of them share."""

from __future__ import annotations

import sys
from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.types import Location, Window
import numpy as np
from numpy.typing import NDArray

LONGEST_NS = 10**9  # ns between two windows: the scene is another one after that
Circle = tuple[float, float, float]  # x, y and radius, px


class UnlitWindow(NamedTuple):
    """The unlit pixels of a window, DN: where it begins and where the light was, px; its sigma."""

    unlit: NDArray[np.generic]
    left: int
    top: int
    x: float
    y: float
    sigma: float
    stamp_ns: int
    looks: int
    binning: tuple[int, int]

    @classmethod
    def of(cls, window: Window, location: Location) -> UnlitWindow:
        """Return that of a window, which has unlit pixels, and of its light."""
        assert window.unlit is not None
        across, down = window.binning
        x, y = window.to_window(location.x, location.y)
        left, top = window.x0 // across, window.y0 // down
        return cls(
            window.unlit, left, top, x + left, y + top, location.sigma, window.stamp_ns,
            window.looks, window.binning,
        )

    def follows(self, before: UnlitWindow) -> bool:
        """Tell whether this window and the one before it may be compared."""
        return (
            0 < self.stamp_ns - before.stamp_ns <= LONGEST_NS
            and self.looks == before.looks and self.binning == before.binning
        )


class ComparedWindows:
    """
    Hand out a light's window with the one before it: each, or one in so many.

    Parameters
    ----------
    every : int
        Windows of which one is handed out once enough is known.

    """

    def __init__(self, every: int) -> None:
        self._every = every
        self._last: UnlitWindow | None = None

    def take(
        self, window: Window, location: Location, number: int, *, rests: bool
    ) -> tuple[UnlitWindow | None, UnlitWindow] | None:
        """
        Take the next window, which has unlit pixels; return the one before, and it.

        Parameters
        ----------
        window : Window
            Of the light.
        location : Location
            That of the light.
        number : int
            How many there were.
        rests : bool
            Whether enough is known: there is None of most windows then.

        """
        before, self._last = self._last, None
        turn = number % self._every if rests else 0
        if turn not in (self._every - 1, 0):
            return None  # it is neither looked at, nor compared with the next one
        self._last = UnlitWindow.of(window, location)
        return None if turn else (before, self._last)


def shared(
    before: UnlitWindow, now: UnlitWindow, *, reach: float, least: int, most: int = sys.maxsize
) -> tuple[Array, Array, Circle, Circle] | None:
    """
    Return the pixels that two windows share, of each, and where its light is in them.

    Parameters
    ----------
    before, now : UnlitWindow
        Of one light.
    reach : float
        Radius of the circles about the light, sigma.
    least, most : int
        Sides of what they share, px: for less there is None, of more the upper left part is taken.

    """
    both = before, now
    left, top = max(each.left for each in both), max(each.top for each in both)
    right = min(left + most, *(each.left + each.unlit.shape[1] for each in both))
    bottom = min(top + most, *(each.top + each.unlit.shape[0] for each in both))
    if right - left < least or bottom - top < least:
        return None
    first, second = (
        np.ascontiguousarray(
            each.unlit[top - each.top:bottom - each.top, left - each.left:right - each.left],
            dtype=float,
        )
        for each in both
    )
    one, other = ((each.x - left, each.y - top, reach * each.sigma) for each in both)
    return first, second, one, other

"""Pixels that clip at a lower level than they are said to: a flat top at one value."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.kernel import kernel
from blob_tracker.types import Window
import numpy as np
from numpy.typing import NDArray

LEAST_PIXELS = 4  # at the highest value, or more than there are in the noise below it
LEAST_NOISE_DN = 0.5  # of lit less unlit: of less pixels are alike by themselves
BELOW_SIGMA = 2.0  # standard deviations below the top, where noise leaves more than at it
WINDOWS = 3  # with the same top, before it is believed


class FlatTop:
    """
    Find out where the pixels of a light are clipped, if it is lower than the saturation.

    So are those of a camera that gives YUV (at 235), or 10 or 12 bits in 16. Noise scatters the
    pixels of a light's peak: many of the highest value and hardly any just below it are clipped.
    From when three windows had the same top, they are set to full scale, and left out as clipped
    ones are. (It is the one value that window, message and location agree on.)

    Attributes
    ----------
    warning : str
        Where they are clipped; empty if it is where they are said to be.

    """

    def __init__(self) -> None:
        self.warning = ''
        self._top, self._windows = -1, 0

    def marked(self, window: Window, noise: float) -> Window:
        """
        Take the next window; return it with what is clipped at full scale.

        Parameters
        ----------
        window : Window
            Of a light, as it is cut out.
        noise : float
            Standard deviation of lit less unlit without the light, DN.

        """
        if window.looks > 1 or window.saturation is None:
            return window
        saturation = int(window.saturation)
        near = math.ceil(BELOW_SIGMA * noise)
        return self.judged(window, noise, highest(window.lit, saturation, near))

    def judged(self, window: Window, noise: float, found: tuple[int, int, int]) -> Window:
        """Do what `marked` does, with what `highest` found in the window."""
        top, count, below = found
        flat = count >= LEAST_PIXELS and count > below and noise > LEAST_NOISE_DN
        if top > self._top if self._windows == WINDOWS else flat and top != self._top:
            self._top, self._windows = top, 0
        if flat and top == self._top:
            self._windows = min(self._windows + 1, WINDOWS)
        self.warning = ''
        if self._windows < WINDOWS or top < self._top:
            return window
        self.warning = (
            f'pixels are clipped at {top} DN, below the saturation of {window.saturation:.0f} DN: '
            f'set saturation to {top}'
        )
        lit = window.lit.copy()
        lit[lit == top] = window.saturation
        return replace(window, lit=lit)


@kernel
def highest(lit: NDArray[np.generic], saturation: int, near: int) -> tuple[int, int, int]:
    """
    Return the highest value below the saturation, in how many pixels, and how many near it.

    It is -1, in none, where as many pixels are clipped at the saturation itself.
    """
    top, full = -1, 0
    for j in range(lit.shape[0]):
        for i in range(lit.shape[1]):
            if top < lit[j, i] < saturation:
                top = int(lit[j, i])
            full += lit[j, i] >= saturation
    count, below = 0, 0
    for j in range(lit.shape[0]):
        for i in range(lit.shape[1]):
            value = int(lit[j, i])
            count += value == top
            below += top - near <= value < top
    return (-1, 0, 0) if full >= count else (top, count, below)


def compile_flat_top() -> None:
    """Compile the loop, or load it from Numba's cache, before the first window needs it."""
    for kind in (np.uint8, np.uint16):
        highest(np.zeros((3, 3), kind), 255, 1)

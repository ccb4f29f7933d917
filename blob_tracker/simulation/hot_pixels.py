"""Pixels of the sensor that are too bright, always or by turns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from blob_tracker.simulation.shot import Shot
import numpy as np
from numpy.typing import NDArray

FRAMES = 4096  # after which the blinking ones start again


@dataclass(frozen=True)
class HotPixels:
    """
    Constant hot pixels, and blinking ones (random telegraph signal) that switch at any frame.

    They belong to the sensor: they stay where they are when the camera moves.

    Parameters
    ----------
    constant, blinking : int
        How many of each.
    amplitude : float
        Mean of their exponentially distributed heights, DN.
    switching : float
        Probability that a blinking one switches from one frame to the next.
    region : (float, float, float, float)
        Left, top, right and bottom border of where they are, as parts of the picture's size.
    seed : int
        Of all of it.

    Examples
    --------
    Ten of them, that stay where they are:

    >>> from blob_tracker.simulation import Scene
    >>> hot, picture = HotPixels(constant=10, blinking=0), np.zeros((240, 320), np.float32)
    >>> hot.draw(picture, Scene(width=320, height=240).shot(0))
    >>> (picture > 0.0).sum().item()
    10

    """

    constant: int = 30
    blinking: int = 15
    amplitude: float = 50.0
    switching: float = 0.1
    region: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)
    seed: int = 1

    @cached_property
    def _pixels(self) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.bool_]]:
        """(2, n) places in parts of the picture, (n,) heights in DN, (FRAMES, n) whether on."""
        random = np.random.Generator(np.random.SFC64(self.seed))
        count = self.constant + self.blinking
        low, high = np.reshape(self.region, (2, 2))
        places = low[:, None] + (high - low)[:, None] * random.random((2, count))
        heights = random.exponential(self.amplitude, count).astype(np.float32)
        switched = random.random((FRAMES, count)) < self.switching
        switched[:, :self.constant] = False
        switched[0, :self.constant] = True
        return places, heights, np.logical_xor.accumulate(switched, axis=0)

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add those that are on."""
        (x, y), heights, on = self._pixels
        height, width = picture.shape
        columns, rows = (x * width).astype(int), (y * height).astype(int)
        np.add.at(picture, (rows, columns), heights * on[shot.index % FRAMES])

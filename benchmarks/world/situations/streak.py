"""13: a light that draws a streak while it is exposed."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import flashing, gaussians
from benchmarks.world.situation import (
    BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

ANGLES = (0.0, 45.0, 90.0)  # degrees, a third of the frames each
NODES, WEIGHTS = np.polynomial.legendre.leggauss(32)  # along a streak: exact to 1e-9 up to 20 px


def frames(count: int, random: np.random.Generator, length: float) -> Iterator[Shot]:
    """Yield streaks about the light's mean place, of a peak as high as that of the plain light."""
    flashes = iter(range(count))

    def light(x: float, y: float) -> Model:
        angle = np.radians(ANGLES[len(ANGLES) * 2 * next(flashes) // (count + 2)])
        parameters = np.array([x, y, 1.0, SIGMA, 0.0, length, angle])
        peak = PEAK / streak(parameters).max()
        parameters[[2, 4]] = peak, BACKGROUND
        return Model(streak, parameters)

    return flashing(count, random, light)


def streak(parameters: Floats) -> Floats:
    """Return the frame: x, y, level, sigma, background, length (px) and angle (rad)."""
    x, y, level, sigma, background, length, angle = parameters
    along = 0.5 * length * NODES
    return gaussians(
        SHAPE, x + along * np.cos(angle), y + along * np.sin(angle), sigma, level * WEIGHTS / 2.0
    ) + background


SITUATIONS = [
    Situation(
        13, 'motion streaks at 0, 45, 90 degrees', f'{length:g} px',
        partial(frames, length=length), r'streak|shorten the exposure',
    )
    for length in (4.0, 8.0, 12.0, 20.0)
]

"""7: a flash that lights up haze or a wall about it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import flashing, gaussians
from benchmarks.world.situation import (
    BACKGROUND, Floats, LARGE, Model, Shot, SIGMA, Situation,
)
import numpy as np

PEAK = 100.0  # DN, of the light
WIDTH = 20.0  # px, sigma of the glow
ASIDE = 20.0  # px, from the light to the middle of the glow


def frames(count: int, random: np.random.Generator, glow: float) -> Iterator[Shot]:
    """Yield a light with a glow of so many DN aside of it."""

    def light(x: float, y: float) -> Model:
        return Model(
            with_glow, np.array([x, y, PEAK, SIGMA, BACKGROUND, x + ASIDE, y, WIDTH, glow])
        )

    return flashing(count, random, light, shape=LARGE)


def with_glow(parameters: Floats) -> Floats:
    """Return the frame: x, y, peak, sigma, background, and x, y, sigma, peak of the glow."""
    x, y, peak, sigma, background, glow_x, glow_y, glow_sigma, glow = parameters
    return gaussians(
        LARGE, [x, glow_x], [y, glow_y], [sigma, glow_sigma], [peak, glow]
    ) + background


SITUATIONS = [
    Situation(
        7, 'glow, sigma 20 px, 20 px aside', f'{glow:g} DN', partial(frames, glow=glow),
        r'glow|haze|lights? up (its|the) (surroundings|scene|wall)',
    )
    for glow in (10.0, 20.0, 40.0)
]

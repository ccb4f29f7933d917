"""14: a light with the tail of a lens that has coma."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import flashing, gaussians
from benchmarks.world.situation import (
    BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

LENGTH = 5.0  # px, of the tail
ANGLE = 0.7  # rad, of its direction
STEPS = np.linspace(0.0, 1.0, 8)  # of the tail
WIDENING = 1.5  # sigma at its end over that at its head


def frames(count: int, random: np.random.Generator, part: float) -> Iterator[Shot]:
    """Yield a light of which a part is in the tail."""

    def light(x: float, y: float) -> Model:
        return Model(partial(comatic, part=part), np.array([x, y, PEAK, SIGMA, BACKGROUND]))

    return flashing(count, random, light)


def comatic(parameters: Floats, part: float) -> Floats:
    """Return the frame: x, y, level, sigma, background. The tail is the lens' own: no unknown."""
    x, y, level, sigma, background = parameters
    widths = sigma * (1.0 + (WIDENING - 1.0) * STEPS)
    # Of the light, not of the peak: a wider pulse is lower.
    tail = part * (1.0 - STEPS) / (1.0 - STEPS).sum() * (sigma / widths) ** 2
    return gaussians(
        SHAPE,
        [x, *(x + LENGTH * STEPS * np.cos(ANGLE))],
        [y, *(y + LENGTH * STEPS * np.sin(ANGLE))],
        [sigma, *widths],
        level * np.array([1.0 - part, *tail]),
    ) + background


SITUATIONS = [
    Situation(
        14, 'comatic tail of 5 px', f'{part:.0%} of the light', partial(frames, part=part),
        r'\bcoma|\btail|misfit|lopsided', centred=True,
    )
    for part in (0.2, 0.4, 0.6)
]

"""20: pulses that no Gaussian fits, of any cause."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import flashing, gaussians
from benchmarks.world.situation import (
    BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

ACROSS, DOWN = 3.4, 1.2  # px, from the light to that on its one side


def frames(count: int, random: np.random.Generator, part: float) -> Iterator[Shot]:
    """Yield a light between two dimmer ones: the middle is true, the shape no Gaussian."""

    def light(x: float, y: float) -> Model:
        return Model(three, np.array([x, y, PEAK, SIGMA, BACKGROUND, part, ACROSS, DOWN]))

    return flashing(count, random, light)


def three(parameters: Floats) -> Floats:
    """Return the frame: x, y, peak, sigma, background, and part and place of the side lights."""
    x, y, peak, sigma, background, part, across, down = parameters
    return gaussians(
        SHAPE, [x, x + across, x - across], [y, y + down, y - down], sigma,
        peak * np.array([1.0, part, part]),
    ) + background


SITUATIONS = [
    Situation(
        20, 'misfit of any cause: side lights', f'{part:g} as bright',
        partial(frames, part=part), r'misfit|no Gaussian|chi2|does not fit',
    )
    for part in (0.2, 0.4, 0.6)
]

"""6: a reflection far from the light, while the light is hidden."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, gaussians, plain, resting
from benchmarks.world.situation import BACKGROUND, PEAK, SHAPE, Shot, SIGMA, Situation
import numpy as np

DISTANCE = 40.0  # px, to the right
PART = 0.5  # of the light's brightness
SHOWN = 20  # flashes between two times that it is hidden
GRACE = 5  # flashes after which the light has to be the target again


def frames(count: int, random: np.random.Generator, hidden: int) -> Iterator[Shot]:
    """
    Yield a light and its reflection; every now and then the light is hidden for some flashes.

    Meanwhile, and for five flashes more, no answer is judged: the reflection is a light in step.
    """
    for index, (x, y) in enumerate(resting(count, random)):
        if index % 2:
            yield Shot(digitised(np.full(SHAPE, BACKGROUND), random), False)
            continue
        turn = index // 2 % (SHOWN + hidden)
        shown = turn >= hidden
        model = plain(x - DISTANCE / 2.0, y)
        mean = gaussians(SHAPE, x + DISTANCE / 2.0, y, SIGMA, PART * PEAK) + BACKGROUND
        if shown:
            mean = mean + model.mean(model.parameters) - BACKGROUND
        yield Shot(
            digitised(mean, random), True, x - DISTANCE / 2.0, y,
            judged=turn >= hidden + GRACE, model=model,
        )


SITUATIONS = [
    Situation(
        6, 'reflection half as bright 40 px away', f'hidden for {hidden} flashes',
        partial(frames, hidden=hidden), r'(two|\d+) lights? flash|reflection|second light',
    )
    for hidden in (2, 5, 15)
]

"""8: a light far beyond full scale."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from benchmarks.world.light import flashing, plain
from benchmarks.world.situation import FULL_SCALE, Model, Shot, Situation
import numpy as np


def frames(count: int, random: np.random.Generator, times: float) -> Iterator[Shot]:
    """Yield a light whose peak is so many times full scale; all above it is lost."""

    def light(x: float, y: float) -> Model:
        model = plain(x, y, times * FULL_SCALE)
        return replace(model, used=model.mean(model.parameters) < FULL_SCALE)

    return flashing(count, random, light)


SITUATIONS = [
    Situation(
        8, 'over-exposed', f'{times:g} x full scale', partial(frames, times=times),
        r'clipped.*exposure|over-?exposed|saturated',
    )
    for times in (8.0, 10.0, 13.0, 27.0, 50.0)
]

"""9: pixels that turn black where it is too bright, or are stuck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from benchmarks.world.light import CENTRE, digitised, flashing, plain
from benchmarks.world.situation import Floats, FULL_SCALE, Model, Shot, Situation
from blob_tracker.types import Pixels
import numpy as np

BLACK = 800.0  # DN, past which a pixel reads 0
BRIGHT = 100.0  # DN, peak beside a stuck pixel


def black_core(count: int, random: np.random.Generator, peak: float) -> Iterator[Shot]:
    """Yield a light so bright that its core is black (black sun)."""

    def light(x: float, y: float) -> Model:
        model = plain(x, y, peak)
        return replace(model, used=model.mean(model.parameters) < FULL_SCALE)

    def develop(mean: Floats, source: np.random.Generator) -> Pixels:
        image = digitised(mean, source)
        image[mean > BLACK] = 0
        return image

    return flashing(count, random, light, develop=develop)


def stuck(count: int, random: np.random.Generator, distance: int) -> Iterator[Shot]:
    """Yield a light about a pixel that is always at full scale, or beside it."""
    column, row = int(CENTRE[0]) + distance, int(CENTRE[1])

    def light(x: float, y: float) -> Model:
        model = plain(x, y, BRIGHT)
        used = np.ones(model.mean(model.parameters).shape, dtype=bool)
        used[row, column] = False
        return replace(model, used=used)

    def develop(mean: Floats, source: np.random.Generator) -> Pixels:
        image = digitised(mean, source)
        image[row, column] = FULL_SCALE
        return image

    return flashing(count, random, light, develop=develop)


SITUATIONS = [
    Situation(
        9, 'black core, past 800 DN', f'peak {peak:g} DN', partial(black_core, peak=peak),
        r'black (core|sun)|clipped.*exposure|over-?exposed|saturated',
    )
    for peak in (1000.0, 2000.0, 4000.0)
] + [
    Situation(
        9, 'pixel stuck at 255', f'{distance} px from the light',
        partial(stuck, distance=distance), r'stuck|hot pixel|defect',
    )
    for distance in (0, 2, 5)
]

"""12: a flood light on a dark room, and no target."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, gaussians, smooth_field
from benchmarks.world.situation import Floats, HEIGHT, SHAPE, Shot, Situation, WIDTH
import numpy as np

DARK = 2.0  # DN
SCALES = (1.5, 6.0, 25.0)  # px, correlation lengths of what the room reflects
ROUGHNESS = (0.08, 0.15, 0.3)  # of the mean, at those
THINGS = 12  # small ones that reflect more
BOXES = 5  # furniture: edges
STAY = 100  # frames in a room


def frames(count: int, random: np.random.Generator, level: float) -> Iterator[Shot]:
    """Yield dark rooms, one after another, that light up as a whole in every other frame."""
    for index in range(count):
        if index % STAY == 0:
            flooded = DARK + level * reflectance(random)
        on = index % 2 == 0
        yield Shot(digitised(flooded if on else np.full(SHAPE, DARK), random), on)


def reflectance(random: np.random.Generator) -> Floats:
    """Return what a room reflects, mean 1: rough walls, furniture, small bright things."""
    room = np.ones(SHAPE)
    for scale, rough in zip(SCALES, ROUGHNESS, strict=True):
        room *= np.exp(rough * smooth_field(SHAPE, scale, random))
    for _ in range(BOXES):
        left, top = random.integers((0, 0), (WIDTH - 20, HEIGHT - 20))
        wide, high = random.integers(8, 40, 2)
        room[top:top + high, left:left + wide] *= random.uniform(0.3, 2.0)
    x, y = random.uniform((5, 5), (WIDTH - 5, HEIGHT - 5), (THINGS, 2)).T
    room += gaussians(
        SHAPE, x, y, random.uniform(1.0, 4.0, THINGS), random.uniform(0.2, 1.5, THINGS)
    )
    return np.asarray(room / room.mean())


SITUATIONS = [
    Situation(
        12, 'flood light in a dark room, no target', f'{level:g} DN',
        partial(frames, level=level), r'(whole|entire) (scene|frame|picture) (flash|light)|flood',
    )
    for level in (20.0, 40.0, 80.0)
]

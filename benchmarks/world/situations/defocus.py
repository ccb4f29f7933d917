"""14: a light out of focus, as a disc or a ring."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import flashing, ring
from benchmarks.world.situation import BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, Situation
import numpy as np

EDGE = 0.7  # px, blur of the edges
RADIUS = 6.0  # px, of rings


def frames(
    count: int, random: np.random.Generator, radius: float, hole: float
) -> Iterator[Shot]:
    """Yield a disc, or with a hole (of the radius) a ring."""

    def light(x: float, y: float) -> Model:
        if hole:
            return Model(annulus, np.array([x, y, PEAK, radius, BACKGROUND, hole]))
        return Model(disc, np.array([x, y, PEAK, radius, BACKGROUND]))

    return flashing(count, random, light)


def disc(parameters: Floats) -> Floats:
    """Return the frame: x, y, level, radius, background."""
    return annulus(np.append(parameters, 0.0))


def annulus(parameters: Floats) -> Floats:
    """Return the frame: x, y, level, radius, background, and the hole over the radius."""
    x, y, level, radius, background, hole = parameters
    return level * ring(SHAPE, x, y, radius, hole, EDGE) + background


SITUATIONS = [
    Situation(
        14, 'disc (defocus)', f'radius {radius:g} px', partial(frames, radius=radius, hole=0.0),
        r'\bdisc|focus|\bring\b',
    )
    for radius in (3.0, 6.0, 12.0)
] + [
    Situation(
        14, 'ring of radius 6 px (defocus)', f'hole {hole:g} R',
        partial(frames, radius=RADIUS, hole=hole), r'\bdisc|focus|\bring\b',
    )
    for hole in (0.3, 0.5, 0.8)
]

"""1: a light that is not dark in the unlit frame, and moves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import circling, digitised, gaussians
from benchmarks.world.situation import (
    BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

SPEED = 0.8  # px a frame


def frames(count: int, random: np.random.Generator, kept: float) -> Iterator[Shot]:
    """Yield a moving light of which the part `kept` is there in the unlit frames."""
    places = circling(count, random, SPEED)
    for index, (x, y) in enumerate(places):
        if index % 2:
            ghost = pair(_parameters(x, y, x, y, kept))[1]
            yield Shot(digitised(ghost, random), False, x, y)
            continue
        # The unlit frame of a pair is the one before.
        ghost_x, ghost_y = places[max(index - 1, 0)]
        parameters = _parameters(x, y, ghost_x, ghost_y, kept)
        yield Shot(
            digitised(pair(parameters)[0], random), True, x, y, model=Model(pair, parameters)
        )


def pair(parameters: Floats) -> Floats:
    """Return lit and unlit frame: x, y, peak, sigma, background, and the ghost's x, y, peak."""
    x, y, peak, sigma, background, ghost_x, ghost_y, ghost = parameters
    return np.stack([
        gaussians(SHAPE, x, y, sigma, peak), gaussians(SHAPE, ghost_x, ghost_y, sigma, ghost)
    ]) + background


def _parameters(x: float, y: float, ghost_x: float, ghost_y: float, kept: float) -> Floats:
    return np.array([x, y, PEAK, SIGMA, BACKGROUND, ghost_x, ghost_y, kept * PEAK])


SITUATIONS = [
    Situation(
        1, 'light kept in the unlit frame, 0.8 px a frame', f'{kept:.0%}',
        partial(frames, kept=kept),
        r'unlit frame.*(light|dark)|ghost|not dark|stays on|on in both',
    )
    for kept in (0.05, 0.1, 0.2, 0.4)
]

"""11: more things that light up than are kept apart."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, gaussians, resting
from benchmarks.world.situation import (
    BACKGROUND, Floats, LARGE, Model, Shot, SIGMA, Situation,
)
import numpy as np

MIDDLE = np.array([LARGE[1] / 2, LARGE[0] / 2])  # px
PEAK = 150.0  # DN, of the target
DOTS = (50.0, 100.0)  # DN
GLINTS = (50.0, 150.0)  # DN
NARROW = (0.8, 1.5)  # px, sigma of a glint
CLEAR = 14.0  # px about the target
GRID = 10  # px between dots


def dots(count: int, random: np.random.Generator, number: int) -> Iterator[Shot]:
    """Yield a light among so many dimmer dots in step, on a grid as a projector throws them."""
    columns, rows = np.meshgrid(
        np.arange(GRID, LARGE[1] - GRID + 1, GRID), np.arange(GRID, LARGE[0] - GRID + 1, GRID)
    )
    grid = np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.3
    free = grid[np.hypot(*(grid - MIDDLE).T) > CLEAR]
    at = random.choice(free, number, replace=False)
    pattern = gaussians(LARGE, at[:, 0], at[:, 1], SIGMA, random.uniform(*DOTS, number))
    for index, (x, y) in enumerate(resting(count, random, LARGE)):
        dark = np.full(LARGE, BACKGROUND)
        if index % 2:
            yield Shot(digitised(dark, random), False)
        else:
            model = _model(x, y)
            yield Shot(
                digitised(model.mean(model.parameters) + pattern, random), True, x, y, model=model,
            )


def glints(count: int, random: np.random.Generator, number: int) -> Iterator[Shot]:
    """Yield a light among glints, so many in each frame, lit or not, anywhere but on it."""
    for index, (x, y) in enumerate(resting(count, random, LARGE)):
        at = random.uniform((0.0, 0.0), (LARGE[1], LARGE[0]), (number, 2))
        at = at[np.hypot(*(at - MIDDLE).T) > CLEAR]
        sigma, peak = random.uniform(*NARROW, len(at)), random.uniform(*GLINTS, len(at))
        sparkle = gaussians(LARGE, at[:, 0], at[:, 1], sigma, peak)
        if index % 2:
            yield Shot(digitised(BACKGROUND + sparkle, random), False)
        else:
            model = _model(x, y)
            yield Shot(
                digitised(model.mean(model.parameters) + sparkle, random), True, x, y, model=model,
            )


def spot(parameters: Floats) -> Floats:
    """Return the plain model on the larger frame."""
    x, y, peak, sigma, background = parameters
    return gaussians(LARGE, x, y, sigma, peak) + background


def _model(x: float, y: float) -> Model:
    return Model(spot, np.array([x, y, PEAK, SIGMA, BACKGROUND]))


SITUATIONS = [
    Situation(
        11, 'dots in step', f'{number} of them', partial(dots, number=number),
        r'\d+ lights? flash|too many|more than \d+',
    )
    for number in (40, 100, 300)
] + [
    Situation(
        11, 'glints at random', f'{number} a frame', partial(glints, number=number),
        r'glint|too many|more than \d+',
    )
    for number in (20, 40, 80)
]

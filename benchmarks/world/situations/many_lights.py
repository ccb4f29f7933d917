"""11: more things that light up than are kept apart."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, gaussians, resting
from benchmarks.world.situation import BACKGROUND, Floats, Model, Shot, SIGMA, Situation
import numpy as np

SHAPE = (240, 320)  # px: 300 dots need room
MIDDLE = np.array([160.0, 120.0])  # px
PEAK = 150.0  # DN, of the target
DOTS = (50.0, 100.0)  # DN
GLINTS = (50.0, 150.0)  # DN
NARROW = (0.8, 1.5)  # px, sigma of a glint
CLEAR = 14.0  # px about the target
GRID = 10  # px between dots


def dots(count: int, random: np.random.Generator, number: int) -> Iterator[Shot]:
    """Yield a light among so many dimmer dots in step, on a grid as a projector throws them."""
    columns, rows = np.meshgrid(
        np.arange(GRID, SHAPE[1] - GRID + 1, GRID), np.arange(GRID, SHAPE[0] - GRID + 1, GRID)
    )
    grid = np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.3
    free = grid[np.hypot(*(grid - MIDDLE).T) > CLEAR]
    x, y = random.choice(free, number, replace=False).T
    pattern = gaussians(SHAPE, x, y, SIGMA, random.uniform(*DOTS, number))
    for index, place in enumerate(_places(count, random)):
        dark = np.full(SHAPE, BACKGROUND)
        if index % 2:
            yield Shot(digitised(dark, random), False)
        else:
            model = _model(place)
            yield Shot(
                digitised(model.mean(model.parameters) + pattern, random), True, *place,
                model=model,
            )


def glints(count: int, random: np.random.Generator, number: int) -> Iterator[Shot]:
    """Yield a light among glints, so many in each frame, lit or not, anywhere but on it."""
    for index, place in enumerate(_places(count, random)):
        at = random.uniform((0.0, 0.0), (SHAPE[1], SHAPE[0]), (number, 2))
        at = at[np.hypot(*(at - MIDDLE).T) > CLEAR]
        sparkle = gaussians(
            SHAPE, *at.T, random.uniform(*NARROW, len(at)), random.uniform(*GLINTS, len(at))
        )
        if index % 2:
            yield Shot(digitised(BACKGROUND + sparkle, random), False)
        else:
            model = _model(place)
            yield Shot(
                digitised(model.mean(model.parameters) + sparkle, random), True, *place,
                model=model,
            )


def spot(parameters: Floats) -> Floats:
    """Return the plain model on the larger frame."""
    x, y, peak, sigma, background = parameters
    return gaussians(SHAPE, x, y, sigma, peak) + background


def _places(count: int, random: np.random.Generator) -> Floats:
    places = resting(count, random)
    return np.asarray(places - np.round(places.mean(axis=0)) + MIDDLE)


def _model(place: Floats) -> Model:
    return Model(spot, np.array([*place, PEAK, SIGMA, BACKGROUND]))


SITUATIONS = [
    Situation(
        11, 'dots in step', f'{number} of them', partial(dots, number=number),
        r'\d+ (lights|things|blobs)?.*in step|(too )?many',
    )
    for number in (40, 100, 300)
] + [
    Situation(
        11, 'glints at random', f'{number} a frame', partial(glints, number=number),
        r'glint|(too )?many',
    )
    for number in (20, 40, 80)
]

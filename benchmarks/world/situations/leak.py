"""15: a shutter that leaks, and charge that runs along the column."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from benchmarks.world.light import circling, digitised, flashing, gaussians, plain
from benchmarks.world.situation import (
    BACKGROUND, Floats, FULL_SCALE, Model, NOISE, PEAK, SHAPE, Shot, SIGMA, Situation,
)
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import Pixels
import numpy as np

SPEED = 4.0  # px a frame
REST = 1.0  # of a frame's time in which the light is seen through the closed shutter
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
BLOOMING = Sensor(noise=NOISE, full_well=NOISE.gain * FULL_SCALE, blooming=True)


def leaking(count: int, random: np.random.Generator, part: float) -> Iterator[Shot]:
    """Yield a moving light of which a part falls on its way through the closed shutter."""
    places = circling(count, random, SPEED)
    for index, (x, y) in enumerate(places):
        if index % 2:
            yield Shot(digitised(np.full(SHAPE, BACKGROUND), random), False)
            continue
        after = places[min(index + 1, count - 1)]
        way = REST * (after - (x, y))
        parameters = np.array([x, y, PEAK, SIGMA, BACKGROUND, part, *way])
        yield Shot(
            digitised(tailed(parameters), random), True, x, y, model=Model(tailed, parameters)
        )


def tailed(parameters: Floats) -> Floats:
    """Return the frame: x, y, level, sigma, background, part in the tail, its way in x and y."""
    x, y, level, sigma, background, part, across, down = parameters
    along = 0.5 * (NODES + 1.0)
    return gaussians(
        SHAPE, [x, *(x + across * along)], [y, *(y + down * along)], sigma,
        level * np.array([1.0 - part, *(part * WEIGHTS / 2.0)]),
    ) + background


def blooming(count: int, random: np.random.Generator, times: float) -> Iterator[Shot]:
    """Yield a light so many times full scale, whose charge runs along the column."""

    def light(x: float, y: float) -> Model:
        return plain(x, y, times * FULL_SCALE)

    def develop(mean: Floats, source: np.random.Generator) -> Pixels:
        return BLOOMING.expose(mean, source)

    for shot in flashing(count, random, light, develop=develop):
        yield replace(shot, model=None)  # where the charge ends cannot be written down


SITUATIONS = [
    Situation(
        15, 'tail of a leaking shutter, 4 px', f'{part:.0%} of the light',
        partial(leaking, part=part), r'\btail|leak|smear|misfit|lopsided',
    )
    for part in (0.05, 0.16, 0.3)
] + [
    Situation(
        15, 'blooming along the column', f'{times:g} x full scale',
        partial(blooming, times=times), r'bloom|clipped.*exposure|over-?exposed|smear',
    )
    for times in (2.0, 4.0, 8.0)
]

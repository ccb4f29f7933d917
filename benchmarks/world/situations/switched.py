"""2: a flash that switches while the rows of the light are exposed."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, gaussians, resting
from benchmarks.world.situation import (
    BACKGROUND, Floats, HEIGHT, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

# Of the light in the lit frame, at the light's own row. It wanders as slowly as light and camera.
SHARES = (0.6, 0.95)
CYCLE = 150  # flashes from the least share back to it


def frames(count: int, random: np.random.Generator, rows: float) -> Iterator[Shot]:
    """Yield a light whose share in the lit frame runs from 1 to 0 over so many rows."""
    start = random.integers(CYCLE)
    for index, (x, y) in enumerate(resting(count, random)):
        wave = 2.0 * abs((index // 2 + start) % CYCLE / CYCLE - 0.5)
        share = SHARES[0] + (SHARES[1] - SHARES[0]) * wave
        parameters = np.array([x, y, PEAK, SIGMA, BACKGROUND, y - (1.0 - share) * rows])
        draw = partial(pair, rows=rows)
        images = draw(parameters)
        lit = index % 2 == 0
        yield Shot(
            digitised(images[0 if lit else 1], random), lit, x, y,
            model=Model(draw, parameters) if lit else None,
        )


def shares(edge: float, rows: float) -> Floats:
    """Return (h,) shares of the light that each row gets: 1 down to the row `edge`, then less."""
    return np.clip(1.0 - (np.arange(HEIGHT) - edge) / rows, 0.0, 1.0)


def pair(parameters: Floats, rows: float) -> Floats:
    """Return lit and unlit frame: x, y, peak, sigma, background and the row of the edge."""
    x, y, peak, sigma, background, edge = parameters
    light = gaussians(SHAPE, x, y, sigma, peak)
    share = shares(edge, rows)[:, None]
    return np.stack([share * light, (1.0 - share) * light]) + background


SITUATIONS = [
    Situation(
        2, 'flash switches while its rows are exposed', f'over {rows} rows',
        partial(frames, rows=rows), r'switch|rolling shutter|rows|shared? (between|with)',
    )
    for rows in (8, 67, 200)
]

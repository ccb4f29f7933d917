"""19: texture behind the light that moves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, plain, resting, smooth_field
from benchmarks.world.situation import BACKGROUND, SHAPE, Shot, Situation
import numpy as np

CORRELATION = 1.5  # px
STEP = (1, 1)  # px a frame, down and to the right


def frames(count: int, random: np.random.Generator, deviation: float) -> Iterator[Shot]:
    """Yield a light before a texture of so many DN that moves 1.4 px a frame."""
    texture = deviation * smooth_field(SHAPE, CORRELATION, random)
    for index, (x, y) in enumerate(resting(count, random)):
        behind = np.roll(texture, (index * STEP[0], index * STEP[1]), axis=(0, 1))
        if index % 2:
            yield Shot(digitised(BACKGROUND + behind, random), False)
        else:
            model = plain(x, y)
            yield Shot(
                digitised(model.mean(model.parameters) + behind, random), True, x, y, model=model
            )


SITUATIONS = [
    Situation(
        19, 'texture that moves 1.4 px a frame', f'{deviation:g} DN',
        partial(frames, deviation=deviation),
        r'(texture|background).*mov|moving (texture|background)',
    )
    for deviation in (0.5, 1.0, 2.0)
]

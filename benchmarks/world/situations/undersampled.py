"""18: a light narrower than a pixel."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import flashing, plain
from benchmarks.world.situation import Shot, Situation
import numpy as np


def frames(count: int, random: np.random.Generator, sigma: float) -> Iterator[Shot]:
    """Yield a light of a sigma below a pixel."""
    return flashing(count, random, partial(plain, sigma=sigma))


SITUATIONS = [
    Situation(
        18, 'undersampled', f'sigma {sigma:g} px', partial(frames, sigma=sigma),
        r'narrow|undersampled|focus',
    )
    for sigma in (0.3, 0.4, 0.5)
]

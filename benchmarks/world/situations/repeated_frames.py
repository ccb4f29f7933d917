"""10: frames that come twice, with a stamp of their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

from benchmarks.world.light import flashing, plain
from benchmarks.world.situation import Shot, Situation
import numpy as np


def frames(count: int, random: np.random.Generator, cadence: int) -> Iterator[Shot]:
    """Yield a flashing light whose every so many frames end with one that comes twice."""
    return islice(_repeated(count, random, cadence), count)


def _repeated(count: int, random: np.random.Generator, cadence: int) -> Iterator[Shot]:
    for index, shot in enumerate(flashing(count, random, plain)):
        yield shot
        if index % cadence == cadence - 1:
            yield replace(shot, on=False)  # a second bearing of it is not asked, and not wrong


SITUATIONS = [
    Situation(
        10, 'frames that come twice, newly stamped', f'every {cadence}th',
        partial(frames, cadence=cadence),
        r'identical|comes? twice|repeated (frame|picture)|duplicate',
    )
    for cadence in (4, 5, 12)
]

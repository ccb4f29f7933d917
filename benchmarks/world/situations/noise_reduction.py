"""4: the camera's own temporal noise reduction."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import circling, flashing, plain
from benchmarks.world.situation import Floats, FULL_SCALE, NOISE, Shot, Situation
from blob_tracker.simulation.quantisation import quantise
from blob_tracker.types import Pixels
import numpy as np

SPEED = 1.0  # px a frame


def frames(count: int, random: np.random.Generator, kept: float) -> Iterator[Shot]:
    """
    Return a moving light through out(t) = kept out(t - 1) + (1 - kept) in(t).

    The camera keeps its state in full and rounds what it gives away. The bound is that of the
    frames before the filter, which can be undone.
    """
    state: Floats | None = None

    def develop(mean: Floats, source: np.random.Generator) -> Pixels:
        nonlocal state
        deviation = np.sqrt(mean / NOISE.gain + NOISE.read_noise**2)
        seen = mean + deviation * source.standard_normal(mean.shape)
        state = seen if state is None else kept * state + (1.0 - kept) * seen
        return quantise(state.astype(np.float32), FULL_SCALE)

    places = circling(count, random, SPEED)
    return flashing(count, random, plain, places=places, develop=develop)


SITUATIONS = [
    Situation(
        4, 'temporal noise reduction, 1 px a frame', f'recursion {kept:g}',
        partial(frames, kept=kept), r'noise reduction|in time|temporal|recursi',
    )
    for kept in (0.1, 0.2, 0.3)
]

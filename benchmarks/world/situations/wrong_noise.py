"""21: a sensor whose noise is not as configured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from benchmarks.world.light import flashing, plain
from benchmarks.world.situation import Floats, FULL_SCALE, Model, NOISE, Shot, Situation
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Pixels, SensorNoise
import numpy as np


def frames(count: int, random: np.random.Generator, noise: SensorNoise) -> Iterator[Shot]:
    """Yield a plain light on a sensor of another noise; the pedestal lifts all of the frame."""

    def light(x: float, y: float) -> Model:
        model = plain(x, y, 100.0)
        model.parameters[4] += noise.black_level
        return replace(model, noise=noise)

    def develop(mean: Floats, source: np.random.Generator) -> Pixels:
        return expose(mean, noise, source, saturation=FULL_SCALE)

    dark = light(0.0, 0.0).parameters[4]
    return flashing(count, random, light, develop=develop, unlit=float(dark))


SITUATIONS = [
    Situation(
        21, 'noise not as configured', name, partial(frames, noise=noise),
        r'black_level|\bgain\b|read_noise',
    )
    for name, noise in (
        ('pedestal of 100 DN', replace(NOISE, black_level=100.0)),
        ('half the gain', replace(NOISE, gain=NOISE.gain / 2.0)),
        ('twice the gain', replace(NOISE, gain=NOISE.gain * 2.0)),
    )
]

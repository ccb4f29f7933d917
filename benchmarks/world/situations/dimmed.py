"""3: a light dimmed by pulses, on a rolling shutter."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, gaussians, resting
from benchmarks.world.situation import (
    BACKGROUND, Floats, HEIGHT, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

PERIOD = 1e-3  # s
DUTY = 0.3  # of the period
ROW_TIME = 30e-6  # s
LEAST = 0.3  # of the brightest band, below which the light may be missed


def frames(count: int, random: np.random.Generator, exposure: float) -> Iterator[Shot]:
    """Yield a light that flickers within the frames in which it is on, at any phase."""
    for index, (x, y) in enumerate(resting(count, random)):
        if index % 2:
            dark = np.full(SHAPE, BACKGROUND)
            yield Shot(digitised(dark, random), False)
            continue
        parameters = np.array([x, y, PEAK, SIGMA, BACKGROUND, random.uniform()])
        draw = partial(banded, exposure=exposure)
        image = draw(parameters)
        bright = (image - BACKGROUND).sum() / gaussians(SHAPE, x, y, SIGMA, PEAK).sum()
        lit = bool(bright >= LEAST)
        yield Shot(
            digitised(image, random), lit, x, y, model=Model(draw, parameters) if lit else None
        )


def shares(phase: float, exposure: float) -> Floats:
    """Return (h,) light of each row over that of the brightest: the pulses within its exposure."""
    start = phase + np.arange(HEIGHT, dtype=np.float64) * ROW_TIME / PERIOD
    light = _pulsed(np.asarray(start + exposure / PERIOD)) - _pulsed(np.asarray(start))
    most = np.floor(exposure / PERIOD) * DUTY + min(exposure / PERIOD % 1.0, DUTY)
    return np.asarray(light / most)


def banded(parameters: Floats, exposure: float) -> Floats:
    """Return the frame: x, y, peak, sigma, background and the phase of the pulses, periods."""
    x, y, peak, sigma, background, phase = parameters
    light = gaussians(SHAPE, x, y, sigma, peak)
    return np.asarray(shares(phase, exposure)[:, None] * light + background)


def _pulsed(periods: Floats) -> Floats:
    """Return how long the light was on since 0, in periods."""
    whole = np.floor(periods)
    return np.asarray(whole * DUTY + np.minimum(periods - whole, DUTY))


SITUATIONS = [
    Situation(
        3, 'dimmed by 1 ms pulses, rolling shutter', f'{1e3 * exposure:g} ms exposure',
        partial(frames, exposure=exposure), r'PWM|pulse width|dimm|bands',
    )
    for exposure in (0.5e-3, 0.8e-3, 1.7e-3)
]

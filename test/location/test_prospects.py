"""What the score says that a second light, a tail or a glow gains, beside what their fits gain."""

from __future__ import annotations

import math

from blob_tracker.location.alternatives import Alternative
from blob_tracker.location.alternatives.glow import glow
from blob_tracker.location.alternatives.tailed import tailed
from blob_tracker.location.alternatives.two_lights import two_lights
from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.pair_model import one_pulse, to_fit
from blob_tracker.location.prospects import gains, promising
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

NOISE = SensorNoise(gain=10.0, read_noise=0.5)
SHAPE, BACKGROUND, PEAK, SIGMA = (11, 11), 20.0, 120.0, 1.6
ROWS, COLUMNS = np.indices(SHAPE)


def pulse(x: float, y: float) -> np.ndarray:
    """Return a pulse of height 1 in the window."""
    return np.asarray(pixel_integrated_gaussian(SHAPE, x, y, SIGMA))


def window(extra: np.ndarray, seed: int) -> tuple[Pair, np.ndarray]:
    """Return a pair with so much more in its lit window, and its round pulse."""
    random = np.random.default_rng(seed)
    lit, unlit = (
        np.rint(random.normal(mean, np.sqrt(mean / NOISE.gain + NOISE.read_noise**2)))
        for mean in (BACKGROUND + PEAK * pulse(5.1, 4.8) + extra, np.full(SHAPE, BACKGROUND))
    )
    pair = Pair(lit, unlit, NOISE, math.inf)
    optimum = one_pulse(pair, np.array([5.1, 4.8, PEAK, BACKGROUND, SIGMA]))
    assert optimum is not None
    return pair, optimum.theta


MORE: dict[Alternative, np.ndarray] = {
    two_lights: 12.0 * pulse(8.2, 6.9),
    tailed: np.sum([1.5 * pulse(5.1 - far, 4.8) for far in np.linspace(0.0, 4.0, 12)], axis=0),
    glow: 5.0 + 0.6 * (COLUMNS - 5.0) + 0.3 * (ROWS - 5.0),
}


@pytest.mark.parametrize('kind', MORE, ids=lambda kind: kind.__name__)
def test_the_score_finds_what_a_fit_gains(kind: Alternative) -> None:
    """To 0.7 to 1.2 times it: the fit bends the pulse with what it adds, the score does not."""
    for seed in range(8):
        pair, theta = window(MORE[kind], seed)
        optimum = one_pulse(pair, theta)
        assert optimum is not None
        base = to_fit(pair, optimum)
        told = gains(pair, theta)
        fit = kind(pair, base)
        assert fit is not None
        assert kind in promising(pair, theta)
        if kind is glow:
            own = told.even if fit.parameters - base.parameters < 6 else told.bent
        else:
            own = told.light if kind is two_lights else told.tail
        gained = 2.0 * (fit.log_likelihood - base.log_likelihood)
        assert own == pytest.approx(gained, rel=0.3)


def test_noise_promises_next_to_nothing() -> None:
    """A plane has two degrees of freedom more than the pulse: three with its level."""
    told = [gains(*window(np.zeros(SHAPE), seed)) for seed in range(200)]
    assert np.mean([each.even for each in told]) == pytest.approx(3.0, abs=0.7)
    assert np.mean([each.bent for each in told]) == pytest.approx(6.0, abs=1.2)
    assert not any(promising(*window(np.zeros(SHAPE), seed)) for seed in range(200))


def test_what_the_pulse_can_gain_itself_is_no_gain() -> None:
    """A pulse that is a tenth of its sigma beside its place leaves the gains as they are."""
    pair, theta = window(np.zeros(SHAPE), 3)
    beside = theta + np.array([0.1 * SIGMA, 0.0, 0.0, 0.0, 0.0])
    for there, here in zip(gains(pair, beside), gains(pair, theta)):
        assert there == pytest.approx(here, abs=1.5)

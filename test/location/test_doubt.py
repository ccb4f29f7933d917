"""A misfit grows the covariance by what it can do to the place, and is named."""

from __future__ import annotations

from blob_tracker.types import SensorNoise
import numpy as np
from support.lights import located, NOISE, pulse


def test_noise_that_is_not_as_configured_is_no_shape() -> None:
    """The covariance grows by chi2, as no part of the residuals is the light's."""
    told = SensorNoise(gain=4.0 * NOISE.gain, read_noise=0.5)
    result = located(pulse, 11, 60, noise=told)
    assert 1.3 < result.nees < 2.9
    assert result.said('of noise, not of shape') > 0.9


def test_an_even_misfit_does_not_move_the_place() -> None:
    """A halo that no model holds: the covariance stays true, and it is said to be even."""
    def light(shape: tuple[int, int], x: float, y: float) -> np.ndarray:
        rows, columns = np.indices(shape)
        far = np.hypot(columns - x, rows - y)
        return pulse(shape, x, y) + 20.0 / (1.0 + (far / 3.0) ** 4)

    result = located(light, 21, 60)
    assert np.mean(result.found.chi2) > 1.5
    assert 1.3 < result.nees < 2.9
    assert result.said('chi2') + result.said('disc') + result.said('ring') > 0.9


def test_a_true_pulse_is_left_alone() -> None:
    """No warning, no growth."""
    result = located(pulse, 13, 400)
    assert len(result.found.warnings) <= 1
    assert 1.8 < result.nees < 2.3

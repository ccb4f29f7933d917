"""A misfit grows the covariance by what it can do to the place, and is named."""

from __future__ import annotations

from blob_tracker.types import SensorNoise
import numpy as np
from support.lights import located, NOISE, pulse


def test_noise_that_is_not_as_configured_is_no_shape() -> None:
    """The covariance grows by chi2, as no part of the residuals is the light's."""
    # Of a quarter of the variance, that of rounding to whole DN among it.
    told = SensorNoise(
        gain=4.0 * NOISE.gain,
        read_noise=np.sqrt(0.25 * (NOISE.read_noise**2 - 3.0 / 12.0)),
    )
    result = located(pulse, 11, 60, noise=told)
    # 8 without any growth; a part of the noise passes for a texture in both windows.
    assert 1.0 < result.nees < 3.5
    assert result.said('of noise, not of shape') > 0.5


def test_an_even_misfit_does_not_move_the_place() -> None:
    """Four spikes that no model holds: the covariance stays true, and it is said to be even."""
    def light(shape: tuple[int, int], x: float, y: float) -> np.ndarray:
        around = ((4.0, 0.0), (-4.0, 0.0), (0.0, 4.0), (0.0, -4.0))
        return pulse(shape, x, y) + 0.15 * sum(pulse(shape, x + u, y + v) for u, v in around)

    result = located(light, 21, 60)
    assert np.mean(result.found.chi2) > 1.5
    assert 1.3 < result.nees < 2.9
    assert result.said('chi2') + result.said('calibrate pulse') > 0.9


def test_a_true_pulse_is_left_alone() -> None:
    """No warning, no growth."""
    result = located(pulse, 13, 400)
    assert len(result.found.warnings) <= 1
    assert 1.8 < result.nees < 2.3

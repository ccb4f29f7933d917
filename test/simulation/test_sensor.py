"""Noise of the stated variance, full scale, and the same bits for the same seed."""

from blob_tracker.simulation import expose
from blob_tracker.types import SensorNoise
import numpy as np
import pytest


@pytest.mark.parametrize('mean', [20.0, 150.0])
def test_variance_is_that_of_the_noise_model(mean: float) -> None:
    """It is m / gain + read_noise^2 + 1/12, within 4 sigma of the sampling error of 1e5 pixels."""
    noise = SensorNoise(gain=10.0, read_noise=1.5)
    pixels = expose(np.full((250, 400), mean), noise, np.random.default_rng(2)).astype(float)
    expected = mean / noise.gain + noise.read_noise**2 + 1 / 12
    assert pixels.mean() == pytest.approx(mean, abs=4 * np.sqrt(expected / pixels.size))
    assert pixels.var() == pytest.approx(expected, rel=4 * np.sqrt(2 / pixels.size))


def test_full_scale_clips_and_sets_the_type() -> None:
    """8 bits up to 255, 16 above; nothing wraps."""
    noise = SensorNoise(gain=np.inf, read_noise=0.0)
    random = np.random.default_rng(0)
    mean = np.array([[-5.0, 12.4, 300.0, 5000.0]])
    assert expose(mean, noise, random).tolist() == [[0, 12, 255, 255]]
    deep = expose(mean, noise, random, saturation=4095)
    assert deep.dtype == np.uint16
    assert deep.tolist() == [[0, 12, 300, 4095]]

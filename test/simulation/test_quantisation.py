"""Numbers of n bits, and the thesis' model of how they come about."""

from blob_tracker.simulation import gain_plus_uniform
from blob_tracker.simulation.quantisation import quantise
import numpy as np
import pytest


@pytest.mark.parametrize('bits, kind', [(1, np.uint8), (4, np.uint8), (8, np.uint8),
                                        (10, np.uint16), (16, np.uint16)])
def test_numbers_go_from_0_to_full_scale(bits: int, kind: type) -> None:
    """And are the nearest; their error is uniform, of the variance 1/12."""
    full_scale = 2**bits - 1
    signal = np.linspace(0.0, full_scale, 100_001, dtype=np.float32)
    found = quantise(signal.copy(), full_scale)
    assert found.dtype == kind
    assert (found.min(), found.max()) == (0, full_scale)
    error = found - signal.astype(float)
    assert np.abs(error).max() <= 0.5
    assert error.var() == pytest.approx(1.0 / 12.0, rel=0.02)
    outside = np.array([-7.0, 1e6], dtype=np.float32)
    assert quantise(outside, full_scale).tolist() == [0, full_scale]


def test_the_thesis_model_adds_what_is_uniform_below_a_half() -> None:
    """Eq. 2.6: u fills (-0.5, 0.5) evenly and knows nothing of the signal."""
    random = np.random.default_rng(3)
    signal = random.uniform(0.0, 255.0, 200_000)
    uniform = gain_plus_uniform(signal, 0.98, random) - 0.98 * signal
    assert -0.5 < uniform.min() < -0.4999 and 0.4999 < uniform.max() < 0.5
    # 4 sigma of the sampling of 200,000: of the mean, the variance and the correlation.
    assert abs(uniform.mean()) < 4.0 * np.sqrt(1 / 12 / 200_000)
    assert uniform.var() == pytest.approx(1 / 12, rel=4.0 * np.sqrt(0.8 / 200_000))
    assert abs(np.corrcoef(uniform, signal)[0, 1]) < 4.0 / np.sqrt(200_000)


def test_the_thesis_noise_comes_on_top() -> None:
    """Eq. 2.7: the variance is that of both."""
    found = gain_plus_uniform(np.full(200_000, 90.0), 1.0, np.random.default_rng(4), deviation=1.0)
    assert found.var() == pytest.approx(1.0 + 1 / 12, rel=4.0 * np.sqrt(2 / 200_000))

"""Noise from the bank is normal, the same for the same seed, and nobody's to change."""

from blob_tracker.simulation.noise_bank import COUNT, NoiseBank
import numpy as np
import pytest


def test_deviates_are_normal() -> None:
    """Mean, variance and tails of 10^6 of them, within 4 sigma of the sampling."""
    deviates = NoiseBank(1, 2).standard_normal((1000, 1000))
    assert deviates.dtype == np.float32
    assert abs(deviates.mean()) < 4e-3
    assert deviates.var() == pytest.approx(1.0, abs=4.0 * np.sqrt(2e-6))
    # 2700 beyond 3 sigma.
    assert (np.abs(deviates) > 3.0).sum() == pytest.approx(2700, abs=4.0 * np.sqrt(2700))


def test_seed_and_index_give_the_start() -> None:
    """The same twice, another for either."""
    first = NoiseBank(1, 2).standard_normal((8, 8))
    np.testing.assert_array_equal(NoiseBank(1, 2).standard_normal((8, 8)), first)
    for seed, index in ((1, 3), (2, 2)):
        assert (NoiseBank(seed, index).standard_normal((8, 8)) != first).any()


def test_it_cannot_be_written_to_nor_outrun() -> None:
    """With a sentence."""
    with pytest.raises(ValueError, match='read-only'):
        NoiseBank(1, 2).standard_normal((8, 8))[0, 0] = 1.0
    with pytest.raises(ValueError, match='the bank holds noise for'):
        NoiseBank(1, 2).standard_normal((COUNT + 1,))

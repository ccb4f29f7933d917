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


def test_it_cannot_be_written_to() -> None:
    """Others use the same."""
    with pytest.raises(ValueError, match='read-only'):
        NoiseBank(1, 2).standard_normal((8, 8))[0, 0] = 1.0


def test_a_frame_of_more_than_half_of_it_is_drawn_anew() -> None:
    """Two of them have no noise in common: a row of the one comes nowhere in the other."""
    shape = (COUNT // 4096 // 2 + 1, 4096)
    first, second = (NoiseBank(1, index).standard_normal(shape) for index in (2, 3))
    np.testing.assert_array_equal(NoiseBank(1, 2).standard_normal(shape), first)
    # Of 32 bits a few are alike by chance.
    assert np.isin(first[0], second).mean() < 0.5

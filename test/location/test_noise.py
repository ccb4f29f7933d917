"""Variance of a pixel, and how far two noises are apart."""

from __future__ import annotations

from blob_tracker.location.noise import pixel_variance, variance_at, variance_ratio
from blob_tracker.types import SensorNoise
import numpy as np
import pytest


def test_ratio_is_taken_where_it_is_most() -> None:
    """A gain four times too high shows in the bright, a read noise twice too high in the dark."""
    levels = np.array([0.0, 1e6])
    true = SensorNoise(8.0, 3.0)
    assert variance_ratio(levels, SensorNoise(32.0, 3.0), true) == pytest.approx(0.25, rel=1e-3)
    dark = (36.0 + 1 / 12) / (9.0 + 1 / 12)
    assert variance_ratio(levels, SensorNoise(8.0, 6.0), true) == pytest.approx(dark)


@pytest.mark.parametrize('level', [0.0, 12.0, 200.0])
def test_the_variance_at_one_level_is_that_of_an_array(level: float) -> None:
    """Bit for bit: the same sum."""
    noise = SensorNoise(40.0, 0.7, 15.0)
    assert variance_at(level, noise) == pixel_variance(np.array([level]), noise)[0]

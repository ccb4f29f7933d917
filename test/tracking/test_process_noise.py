"""The process noise that recorded bearings speak for."""

from __future__ import annotations

from blob_tracker.tracking import MODELS, PlatformRates, TrackingError
from blob_tracker.tracking.process_noise import log_likelihood, process_noise
from blob_tracker.types import Bearing
import numpy as np
import pytest
from support.consistency import integrated, measured

TIMES = np.arange(150) / 30.0
RUNS = 6


def recorded(order: int, noise: float, seed: int) -> list[Bearing]:
    """Return bearings of some runs of five seconds, with seconds between them."""
    bearings = []
    for run in range(RUNS):
        angles = integrated(TIMES, order, noise, seed + run)[:, :, 0]
        bearings += measured(TIMES + 10.0 * run, angles, 0.1, seed + run)
    return bearings


@pytest.mark.parametrize(('model', 'true'), [
    ('constant_velocity', 40.0), ('constant_acceleration', 30.0),
])
def test_the_noise_that_was_drawn_is_found(model: str, true: float) -> None:
    """Within its own deviation: 900 bearings of 2 axes tell it to a few per cent."""
    found = process_noise(recorded(MODELS[model].size // 2, true, 60), model)
    assert found == pytest.approx(true, rel=0.12)


def test_of_a_still_platform_it_is_the_targets() -> None:
    """With and without rates that are all zero the same."""
    bearings = recorded(2, 40.0, 70)
    platform = PlatformRates(memory=100.0)
    for stamp in range(0, 60_000_000_000, 50_000_000):
        platform.push(stamp, np.zeros(3))
    without = process_noise(bearings, 'constant_velocity')
    assert process_noise(bearings, 'constant_velocity', platform=platform) == pytest.approx(
        without, rel=1e-3
    )


def test_gaps_and_order() -> None:
    """A gap is not filtered over, and the order of a recording does not matter."""
    bearings = recorded(2, 40.0, 80)
    whole = log_likelihood(bearings, 'constant_velocity', 40.0)
    assert log_likelihood(bearings[::-1], 'constant_velocity', 40.0) == whole
    assert whole[1] == RUNS * (150 - 4)
    # Each noise is judged by the same innovations.
    assert log_likelihood(bearings, 'constant_velocity', 1e5)[1] == whole[1]


def test_too_few_are_refused() -> None:
    """With how many it takes."""
    bearings = measured(TIMES[:40], np.zeros((40, 2)), 0.1, 9)
    with pytest.raises(TrackingError, match='36 bearings follow .*; 50 at least'):
        process_noise(bearings, 'constant_velocity')

"""Past its newest sample the platform turns on along the line through the last ones."""

from __future__ import annotations

from blob_tracker.tracking import PlatformRates
from blob_tracker.tracking.angular_velocity import FITTED_S
import numpy as np
import pytest

MS = 1_000_000
NEWEST = 500 * MS


def pushed(rates: np.ndarray, variance: float = 0.0) -> PlatformRates:
    """Return rates about the vertical axis, 5 ms apart, the last one at NEWEST."""
    platform = PlatformRates()
    for index, rate in enumerate(rates):
        platform.push(NEWEST - (len(rates) - 1 - index) * 5 * MS, [0.0, rate, 0.0], variance)
    return platform


def turned(platform: PlatformRates, ahead: float) -> float:
    """Return by how much the base turns to the right in so many s past the newest sample, rad."""
    turn, _ = platform.between(NEWEST, NEWEST + round(1e9 * ahead))
    return float(np.arctan2(turn[2, 0], turn[0, 0]))


def test_a_steady_acceleration_goes_on() -> None:
    """2 rad/s^2 from 0.3 rad/s: exact, where the last rate held would be off by a t^2 / 2."""
    times = 5e-3 * np.arange(-40, 1)
    platform = pushed(0.3 + 2.0 * times)
    assert turned(platform, 0.05) == pytest.approx(0.3 * 0.05 + 0.5 * 2.0 * 0.05**2, abs=1e-9)
    assert platform.rate_at(NEWEST + 50 * MS)[1] == pytest.approx(0.4, abs=1e-9)


def test_of_few_samples_the_newest_holds() -> None:
    """Three are too few for a line that can be believed."""
    assert turned(pushed(np.array([0.1, 0.2, 0.3])), 0.05) == pytest.approx(0.015, abs=1e-12)


def test_the_variance_is_that_of_the_line() -> None:
    """Of 2000 draws of white noise, 45 ms ahead; their variance is known to 3 %, three times."""
    random = np.random.default_rng(4)
    count = round(FITTED_S / 5e-3) + 5
    ends = [turned(pushed(random.normal(scale=1e-3, size=count)), 0.045) for _ in range(2000)]
    _, variance = pushed(np.zeros(count), 1e-6).between(NEWEST, NEWEST + 45 * MS)
    assert np.var(ends) / variance == pytest.approx(1.0, abs=0.1)


def test_a_swing_is_predicted_better_than_by_its_last_rate() -> None:
    """0.45 Hz, 45 ms ahead: the acceleration's share, 90 % of the error, is gone."""
    swing = 2.0 * np.pi * 0.45
    errors = []
    for phase in np.linspace(0.0, 2.0 * np.pi, 20):
        times = 5e-3 * np.arange(-40, 1)
        platform = pushed(np.cos(swing * times + phase))
        truth = (np.sin(swing * 0.045 + phase) - np.sin(phase)) / swing
        errors.append([turned(platform, 0.045) - truth, 0.045 * np.cos(phase) - truth])
    line, held = np.sqrt(np.mean(np.square(errors), axis=0))
    assert line < 0.15 * held


@pytest.mark.parametrize('within', [1_000, 20_000, 200_000])
def test_a_burst_tells_no_slope(within: int) -> None:
    """Of 20 samples, stamped on arrival within 0.2 ms and less, the newest rate holds."""
    random = np.random.default_rng(5)
    platform = PlatformRates()
    for burst in range(3):
        rates = random.normal(scale=3e-3, size=20)
        for index, rate in enumerate(rates):
            late = (19 - index) * within // 20
            platform.push(NEWEST - (2 - burst) * 100 * MS - late, [0.0, rate, 0.0])
    assert turned(platform, 0.045) == pytest.approx(0.045 * rates[-1], abs=1e-9)

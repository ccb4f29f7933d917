"""
Errors as large as the covariance says, innovations that leave nothing to be predicted.

On motions drawn from the models, and on vehicles. All bounds are those of 95 %: of other seeds one
in twenty is outside.
"""

from __future__ import annotations

from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import MODELS, PlatformRates, Tracker
from blob_tracker.tracking.process_noise import process_noise
import numpy as np
import pytest
from support.consistency import (
    bounds,
    followed,
    integrated,
    measured,
    nanoseconds,
    portmanteau,
    seen_from,
    share_within,
)

RUNS = 60
SEED = 100
# Of an instant's bounds; over a hundred instants, of which one in ten is news, the share that is
# within has the deviation of 0.07.
SHARE = 0.85
SIGMA = 0.1  # mrad, of a bearing
TIMES = np.arange(110) / 30.0
# Hz, well above the 60 Hz of the drone's rotors, between whose samples the rate is not linear, and
# rad/s: 0.004 degrees a second a root of Hz, of an inexpensive gyro.
GYRO_RATE, GYRO_NOISE = 500.0, 1.6e-3
TARGET = 5.0  # mrad/s^2: what the target does of its own
REHEARSALS = range(900, 903)  # seeds of rides from which the process noise is found


@pytest.mark.parametrize(('model', 'noise', 'irregular'), [
    ('constant_velocity', 30.0, False), ('constant_velocity', 30.0, True),
    ('constant_acceleration', 20.0, False), ('constant_acceleration', 20.0, True),
])
def test_motion_of_the_model(model: str, noise: float, irregular: bool) -> None:
    """NEES, NIS and whiteness, with regular and irregular stamps."""
    times = TIMES
    if irregular:
        times = np.cumsum(np.random.default_rng(5).choice([0.005, 0.033, 0.12], TIMES.size))
    innovations, nees = [], []
    for seed in range(SEED, SEED + RUNS):
        truth = integrated(times, MODELS[model].size // 2, noise, seed, first=30.0)[:, :, 0]
        tracker = Tracker(model, acceleration=noise, jerk=noise, gate_sigma=np.inf)
        each = followed(tracker, measured(times, truth, SIGMA, seed), truth)
        innovations.append(each[0])
        nees.append(each[1])
    stack = np.array(innovations)
    low, high = bounds(stack.size)
    assert low < np.sum(stack**2) < high
    assert portmanteau(stack) < 1.0
    assert share_within(np.array(nees), 2) > SHARE


@pytest.mark.parametrize('motion', list(MOTIONS))
def test_stabilised(motion: str) -> None:
    """The vehicle's rotation known from a noisy gyro: the filter sees the target alone."""
    innovations, nees = [], []
    for seed in range(SEED, SEED + RUNS):
        ride = MOTIONS[motion].ride(TIMES[-1] + 0.2, seed)
        level = integrated(TIMES, 2, TARGET, seed)[:, :, 0]
        truth = seen_from(ride, TIMES, level)
        platform = PlatformRates(memory=10.0)
        ticks = np.arange(0.0, TIMES[-1] + 0.1, 1.0 / GYRO_RATE)
        noise = GYRO_NOISE * np.random.default_rng([seed, 3]).standard_normal((ticks.size, 3))
        for stamp, rate in zip(nanoseconds(ticks), ride.rates(ticks) + noise):
            platform.push(stamp, rate, GYRO_NOISE**2)
        tracker = Tracker(platform=platform, stabilised_acceleration=TARGET, gate_sigma=np.inf)
        each = followed(tracker, measured(TIMES, truth, SIGMA, seed), truth)
        assert tracker.platform_gap == ''
        innovations.append(each[0])
        nees.append(each[1])
    stack = np.array(innovations)
    low, high = bounds(stack.size)
    assert low < np.sum(stack**2) < high
    assert portmanteau(stack) < 1.0
    assert share_within(np.array(nees), 2) > SHARE


@pytest.mark.parametrize('motion', list(MOTIONS))
def test_unstabilised(motion: str) -> None:
    """
    The vehicle's rotation unknown: it is the process noise, found on other rides.

    The errors are as stated and the innovations of the stated size. White they are not: the
    acceleration of a vehicle swings back, and its axes differ; docs/tracking.md has the figures.
    """
    times = np.arange(300) / 30.0
    level = np.zeros((times.size, 2))
    found = []
    for seed in REHEARSALS:
        truth = seen_from(MOTIONS[motion].ride(10.5, seed), times, level)
        found.append(process_noise(measured(times, truth, SIGMA, seed), 'constant_acceleration'))
    jerk = float(np.exp(np.mean(np.log(found))))
    innovations, nees = [], []
    for seed in range(SEED, SEED + RUNS):
        truth = seen_from(MOTIONS[motion].ride(10.5, seed), times, level)
        tracker = Tracker('constant_acceleration', jerk=jerk, gate_sigma=np.inf)
        each = followed(tracker, measured(times, truth, SIGMA, seed), truth)
        innovations.append(each[0])
        nees.append(each[1])
    assert share_within(np.array(nees), 2) > SHARE
    # Rides differ in how wild they are, and both axes have one process noise.
    assert np.mean(np.square(innovations)) == pytest.approx(1.0, abs=0.1)

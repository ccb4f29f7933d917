"""The vehicles turn as far as they are said to, and their own limit is one."""

from __future__ import annotations

from math import pi, sqrt

from blob_tracker.simulation.platform_motion import (
    AXES, MOTIONS, PlatformMotion, Process, process_of, Ride, Shock, Swing, turn_about,
)
import numpy as np
import pytest

TIMES = np.arange(0.0, 400.0, 0.05)


@pytest.mark.parametrize('name', MOTIONS)
def test_a_ride_has_the_deviations_that_are_asked_for(name: str) -> None:
    """400 s are some 60 independent swings of the slowest: 10 % of a deviation, three of them."""
    motion = MOTIONS[name]
    angles = motion.ride(400.0, 1, interval=0.05).angles(TIMES[:-1])
    asked = [sqrt(sum(each.deviation**2 for each in getattr(motion, axis))) for axis in AXES]
    assert angles.std(axis=0) == pytest.approx(asked, rel=0.3)
    assert (angles == motion.ride(400.0, 1, interval=0.05).angles(TIMES[:-1])).all()
    assert (angles != motion.ride(400.0, 2, interval=0.05).angles(TIMES[:-1])).any()


def test_a_step_is_exact() -> None:
    """Two steps are one of twice the length, and a stationary state stays so."""
    process = MOTIONS['sea'].process('roll')
    half, added = process.step(0.05)
    whole, both = process.step(0.1)
    assert half @ half == pytest.approx(whole, abs=1e-9)
    assert half @ added @ half.T + added == pytest.approx(both, rel=1e-6, abs=1e-12)
    kept = whole @ process.stationary @ whole.T + both
    assert kept == pytest.approx(process.stationary, rel=1e-6, abs=1e-12)


def test_rates_are_what_a_gyro_feels() -> None:
    """Over 0.1 ms the rotation turns by the rate; a central difference errs by 1e-6 rad/s."""
    ride = MOTIONS['sea'].ride(10.0, 3)
    times, step = np.array([1.234, 5.0, 7.77]), 1e-4
    before, after = ride.rotations(times - step / 2), ride.rotations(times + step / 2)
    turned = np.swapaxes(before, -1, -2) @ after
    found = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]], axis=1) / step
    assert found == pytest.approx(ride.rates(times), abs=1e-5)


def test_the_signs_are_those_of_a_bearing() -> None:
    """A bow that goes up points up, one that goes to the right points to the right."""
    angles = np.array([[0.0, 0.1, 0.0], [0.0, 0.1, 0.0]])
    up = Ride(1.0, angles, np.zeros((2, 3))).rotations(np.array([0.5]))[0] @ (0.0, 0.0, 1.0)
    assert up == pytest.approx([0.0, -np.sin(0.1), np.cos(0.1)])
    assert turn_about(1, np.array(0.1)) @ (0.0, 0.0, 1.0) == pytest.approx(
        [np.sin(0.1), 0.0, np.cos(0.1)])
    assert turn_about(2, np.array(0.1)) @ (1.0, 0.0, 0.0) == pytest.approx(
        [np.cos(0.1), np.sin(0.1), 0.0])


def test_a_shock_solves_its_equation() -> None:
    """The differences of the angle, 0.1 ms apart, to the third digit of the pulse."""
    shock = Shock(0.5, (0.0, 1.0, 0.0), duration=0.2, frequency=0.7, damping=0.2)
    step = 1e-4
    times = np.arange(0.0, 3.0, step)
    angle, rate = shock.swing(times)
    assert np.gradient(angle, step)[1:-1] == pytest.approx(rate[1:-1], abs=1e-5)
    turn = 2.0 * pi * 0.7
    moment = np.gradient(rate, step) + 2.0 * 0.2 * turn * rate + turn**2 * angle
    since = times - 0.5
    asked = np.where((since > 0) & (since < 0.2), 0.5 - 0.5 * np.cos(2 * pi * since / 0.2), 0.0)
    assert moment[1:-1] == pytest.approx(asked[1:-1], abs=1e-3)


def test_no_prediction_beats_the_limit_and_the_true_filter_reaches_it() -> None:
    """A Kalman filter with the true process, run on 4000 angles: 5 % of a standard deviation."""
    process: Process = process_of((Swing(0.05, 0.4, 0.1, 0.1),))
    interval, horizon, variance = 1.0 / 30.0, 0.1, 1e-8
    random = np.random.default_rng(7)
    ride = PlatformMotion((Swing(0.05, 0.4, 0.1, 0.1),), (Swing(1e-9, 1.0, 0.5, 0.1),),
                          (Swing(1e-9, 1.0, 0.5, 0.1),)).ride(140.0, 7)
    times = interval * np.arange(4000.0)
    seen = ride.angles(times)[:, 0] + 1e-4 * random.standard_normal(times.size)
    step, added = process.step(interval)
    ahead, _ = process.step(horizon)
    state, covariance, errors = np.zeros(3), process.stationary, []
    for time, angle in zip(times, seen):
        gain = covariance @ process.angle / (process.angle @ covariance @ process.angle + variance)
        state = state + gain * (angle - process.angle @ state)
        covariance = covariance - np.outer(gain, process.angle @ covariance)
        errors.append(process.angle @ ahead @ state - ride.angles(time + horizon)[0])
        state, covariance = step @ state, step @ covariance @ step.T + added
    limit = process.prediction_limit(horizon, interval=interval, variance=variance)
    assert np.std(errors[50:]) == pytest.approx(limit, rel=0.05)
    held = np.std(ride.angles(times + horizon)[:, 0] - ride.angles(times)[:, 0])
    assert limit < 0.2 * held

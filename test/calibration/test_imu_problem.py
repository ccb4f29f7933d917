"""Residuals of a gyro beside a camera: nothing at the truth, and strays stand out."""

from __future__ import annotations

from blob_tracker.calibration.imu_problem import ImuProblem
from blob_tracker.tracking.gyro_fit import intervals_of
import numpy as np
import pytest
from support.turned_imu import BEARING, draw, Drawn, NOISE


def problem_of(drawn: Drawn, directions: np.ndarray | None = None) -> ImuProblem:
    """Return the problem that begins with the true turn."""
    times, seen, covariances, gyro_times, rates = drawn.measured
    if directions is None:
        directions = seen
    within = (times > 0.3) & (times < times[-1] - 0.3)
    return ImuProblem(
        times[within], directions[within], covariances[within],
        intervals_of(times[within], 0.02, 0.3), gyro_times, rates, drawn.turn.as_matrix())


def test_at_the_truth_nothing_but_noise_is_left() -> None:
    """Of two bearings, and of the gyro over an interval of 50 ms."""
    drawn = draw(5)
    truth = np.concatenate([np.zeros(3), drawn.others])
    problem = problem_of(drawn)
    expected = np.sqrt(2.0 * BEARING**2 + NOISE**2 * 0.05)
    # 450 residuals: their rms is known to 3.5 %.
    assert problem.residuals(truth).std() == pytest.approx(expected, rel=0.15)
    assert problem.noise(truth) == pytest.approx(NOISE, rel=0.3)


def test_a_stray_bearing_spoils_its_two_intervals() -> None:
    """And no other one."""
    drawn = draw(5)
    truth = np.concatenate([np.zeros(3), drawn.others])
    clean = problem_of(drawn).agree(truth)
    directions = drawn.measured[1].copy()
    directions[100] = directions[100] + [0.01, 0.0, 0.0]
    spoilt = problem_of(drawn, directions).agree(truth)
    assert clean.all()
    assert np.flatnonzero(~spoilt).tolist() == [95, 96]  # the first four bearings are no more in

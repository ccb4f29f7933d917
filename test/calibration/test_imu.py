"""How an IMU sits beside a camera: within its sigmas, and a sentence where it cannot be told."""

from __future__ import annotations

from blob_tracker.calibration.imu import calibrate_imu, ImuError
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.turned_imu import draw, Drawn, NOISE

DRAWS = 100


def test_the_truth_is_within_its_own_sigmas() -> None:
    """Over 100 draws: chi-square of 8, and no quantity is off by itself."""
    errors, squared, noises = [], [], []
    for seed in range(DRAWS):
        drawn = draw(seed, duration=16.0)
        result = calibrate_imu(*drawn.measured)
        found = np.array([result.offset, *result.bias, result.scale])
        turned = (Rotation.from_matrix(result.turn) * drawn.turn.inv()).as_rotvec()
        error = np.concatenate([turned, found - drawn.others])
        squared.append(error @ np.linalg.solve(result.covariance, error))
        errors.append(error / result.sigmas)
        noises.append(result.noise)
    # The mean of 100 is known to 0.4; beyond 30 is one of 5000.
    assert np.mean(squared) == pytest.approx(8.0, abs=1.3)
    assert np.max(squared) < 30.0
    assert np.mean(noises) == pytest.approx(NOISE, rel=0.15)
    np.testing.assert_allclose(np.std(errors, axis=0), 1.0, atol=0.3)
    assert result.sigmas[:3].max() < 1e-3


@pytest.mark.parametrize('drawn, sentence', [
    (draw(1, (1e-3, 1e-3, 1e-3)), 'the light moves too little in the picture'),
    (draw(1, (0.0, 0.0, 1.0)), 'the turn about y of the camera is known to . degrees only'),
    (draw(1, (0.0, 1.0, 0.0)), 'the turn about x of the camera is known to . degrees only'),
    (draw(1, moves=0.02), 'the light moves otherwise than camera and gyro do'),
    (draw(1, duration=4.0), 'pairs of bearings follow each other'),
])
def test_what_cannot_be_told_is_said(drawn: Drawn, sentence: str) -> None:
    """Too little turning, one axis only, a light that moves, too short a time."""
    with pytest.raises(ImuError, match=sentence):
        calibrate_imu(*drawn.measured)


def test_degrees_are_told() -> None:
    """And not calibrated away."""
    times, directions, covariances, ticks, rates = draw(1).measured
    with pytest.raises(ImuError, match='its rates are in degrees/s'):
        calibrate_imu(times, directions, covariances, ticks, np.degrees(rates))


def test_stamps_twice_and_bearings_without_a_covariance_are_passed_over() -> None:
    """The result is that of the others."""
    times, directions, covariances, gyro_times, rates = draw(1, duration=16.0).measured
    unknown = covariances.copy()
    unknown[::50] = np.nan
    twice = np.repeat(np.arange(len(gyro_times)), 1 + (np.arange(len(gyro_times)) % 9 == 0))
    found = calibrate_imu(times, directions, unknown, gyro_times[twice], rates[twice])
    kept = np.isfinite(unknown[:, 0, 0])
    expected = calibrate_imu(
        times[kept], directions[kept], covariances[kept], gyro_times, rates)
    np.testing.assert_allclose(found.turn, expected.turn, atol=1e-9)


@pytest.mark.parametrize('rates, sentence', [
    (0.0, 'all rates of the gyro are 0'), (np.nan, 'are no numbers'),
])
def test_a_gyro_that_says_nothing(rates: float, sentence: str) -> None:
    """It is named, and no other cause."""
    times, directions, covariances, gyro_times, gyro = draw(1, duration=8.0).measured
    with pytest.raises(ImuError, match=sentence):
        calibrate_imu(times, directions, covariances, gyro_times, gyro * 0.0 + rates)

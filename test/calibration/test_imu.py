"""How an IMU sits beside a camera: within its sigmas, and a sentence where it cannot be told."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.calibration.imu import calibrate_imu, ImuCalibration, ImuError
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.turned_imu import Array, draw, Drawn, NOISE

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
    (0.0, 'all rates of the gyro are 0'), (np.nan, 'are not numbers'),
])
def test_a_gyro_that_says_nothing(rates: float, sentence: str) -> None:
    """It is named, and no other cause."""
    times, directions, covariances, gyro_times, gyro = draw(1, duration=8.0).measured
    with pytest.raises(ImuError, match=sentence):
        calibrate_imu(times, directions, covariances, gyro_times, gyro * 0.0 + rates)


def turned_off(result: ImuCalibration, drawn: Drawn) -> float:
    """Return by how many standard deviations the turn is off, of 3."""
    error = (Rotation.from_matrix(result.turn) * drawn.turn.inv()).as_rotvec()
    return float(np.sqrt(error @ np.linalg.solve(result.covariance[:3, :3], error)))


@pytest.mark.parametrize('share, angle', [(0.01, 0.01), (0.03, 0.3), (0.1, 0.1)])
def test_bearings_of_another_light_are_left_out(share: float, angle: float) -> None:
    """The turn is as good as without them, and their share is told: each spoils two intervals."""
    drawn = draw(2, duration=16.0)
    times, directions, covariances, gyro_times, rates = drawn.measured
    stray = np.random.default_rng(4).choice(len(times), int(share * len(times)), replace=False)
    directions = directions.copy()
    directions[stray] = Rotation.from_rotvec([0.0, angle, 0.0]).apply(directions[stray])
    result = calibrate_imu(times, directions, covariances, gyro_times, rates)
    assert turned_off(result, drawn) < 4.0  # one of 900 is beyond
    assert result.stray == pytest.approx(2.0 * share, abs=0.7 * share)


def test_a_slow_gyro_is_as_right_as_its_sigma() -> None:
    """At 20 Hz its samples are far apart beside the cones that its axes describe."""
    drawn = draw(1, duration=20.0)
    times, directions, covariances, gyro_times, rates = drawn.measured
    result = calibrate_imu(times, directions, covariances, gyro_times[::5], rates[::5])
    assert turned_off(result, drawn) < 4.0


def limited(drawn: Drawn) -> tuple[Array, Array]:
    """Return samples of a gyro that turned faster than it can say."""
    rates = drawn.measured[4]
    most = 0.5 * np.abs(rates).max()
    return drawn.measured[3], np.clip(rates, -most, most)


def parted(drawn: Drawn) -> tuple[Array, Array]:
    """Return samples of which a second is missing now and then."""
    gyro_times, rates = drawn.measured[3:]
    kept = (gyro_times % 4.0) > 1.0
    return gyro_times[kept], rates[kept]


def rare(drawn: Drawn) -> tuple[Array, Array]:
    """Return samples at 5 Hz."""
    gyro_times, rates = drawn.measured[3:]
    return gyro_times[::20], rates[::20]


@pytest.mark.parametrize('spoilt, sentence', [
    (limited, 'the gyro is at its limit about ., [0-9.]+ rad/s, in .* samples: turn slower'),
    (parted, 'gaps between samples of the gyro, of up to 1 s'),
    (rare, 'the gyro speaks at 5 Hz; 7 are the least'),
])
def test_what_the_gyro_suffers_from_is_named(
    spoilt: Callable[[Drawn], tuple[Array, Array]], sentence: str
) -> None:
    """And not the light, which is all right."""
    drawn = draw(1, duration=20.0)
    with pytest.raises(ImuError, match=sentence):
        calibrate_imu(*drawn.measured[:3], *spoilt(drawn))

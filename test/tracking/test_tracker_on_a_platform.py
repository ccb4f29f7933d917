"""A tracker whose camera is turned: by a platform, and by a pan/tilt head."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import MODELS, PanTiltAngles, PlatformRates, Tracker, TrackingError
from blob_tracker.types import Bearing
import numpy as np
import pytest
from support.consistency import measured, nanoseconds, of_rays, rays_of, seen_from
from support.steady_bearings import COVARIANCE, fed, FRAME, MS, present, steady


def turning(
    tracker_platform: PlatformRates, duration: float, rate: Sequence[float] | np.ndarray
) -> None:
    """Push a constant angular velocity at 200 Hz."""
    for stamp in range(0, round(duration * 1e9), 5 * MS):
        tracker_platform.push(stamp, rate)


def on_a_turning_base(count: int, rate: np.ndarray) -> list[Bearing]:
    """Return bearings, without noise, of a resting target from a base that turns."""
    bearings = []
    for index in range(count):
        angle = np.linalg.norm(rate) * index * 0.033
        axis = rate / np.linalg.norm(rate)
        ray = np.array([0.1, -0.05, 1.0])
        # Rodrigues' formula, backwards.
        turned = (ray * np.cos(angle) - np.cross(axis, ray) * np.sin(angle)
                  + axis * (axis @ ray) * (1 - np.cos(angle)))
        azimuth, elevation = of_rays(turned[None])[0]
        bearings.append(Bearing(azimuth, elevation, COVARIANCE, index * FRAME))
    return bearings


@pytest.mark.parametrize('model', list(MODELS))
def test_a_gap_of_the_platforms_rates(model: str) -> None:
    """The track goes on without them, at the rate that the picture shows, and says so."""
    rate = np.array([0.1, -0.4, 0.2])
    platform = PlatformRates(hold=0.1)
    turning(platform, 0.5, rate)
    tracker = Tracker(model, platform=platform)
    bearings = on_a_turning_base(30, rate)
    for index, bearing in enumerate(bearings):
        track = tracker.update(bearing)
        if bearing.stamp_ns < 595 * MS:
            assert tracker.platform_gap == ''
            if index > 5:
                np.testing.assert_allclose(track.rate, 0.0, atol=0.3)
        else:
            assert 'it holds for 0.1 s' in tracker.platform_gap
            np.testing.assert_allclose(present(tracker.seen_at(bearing.stamp_ns)).rate,
                                       track.rate)
    assert tracker.refused == 0
    apparent = np.diff([[each.azimuth, each.elevation] for each in bearings[-2:]], axis=0)[0]
    # The picture's acceleration over half a frame, 0.4^2 rad/s^2 / 2 x 0.033.
    np.testing.assert_allclose(track.rate, apparent / 0.033, atol=3.0)
    # The rates come again: the target is at rest.
    for stamp in range(900 * MS, 2000 * MS, 5 * MS):
        platform.push(stamp, rate)
    for bearing in on_a_turning_base(50, rate)[30:]:
        track = tracker.update(bearing)
    assert tracker.platform_gap == ''
    np.testing.assert_allclose(track.rate, 0.0, atol=0.3)
    assert (tracker.refused, tracker.begun) == (0, 1)


@pytest.mark.parametrize('model', list(MODELS))
def test_rates_that_come_again_after_the_bearing(model: str) -> None:
    """A bearing within the gap of a gyro that is back: followed and told without its rates."""
    platform = PlatformRates()
    turning(platform, 0.3, [0.0, 0.0, 0.0])
    platform.push(600 * MS, np.zeros(3))
    tracker = Tracker(model, platform=platform)
    for bearing in steady(18, rate=0.0):
        tracker.update(bearing)
        tracker.at(bearing.stamp_ns)
        tracker.seen_at(bearing.stamp_ns)
    assert tracker.platform_gap == 'angular velocities are more than 0.2 s apart'
    for ask in (tracker.at, tracker.seen_at):
        track = present(ask(bearing.stamp_ns))
        np.testing.assert_allclose(track.state[:2], 0.0, atol=1e-6)
    assert tracker.refused == 0


def test_without_any_rates_the_platform_changes_nothing() -> None:
    """But says that they are missing."""
    with_platform, without = Tracker(platform=PlatformRates()), Tracker()
    for bearing in steady(20):
        first, second = with_platform.update(bearing), without.update(bearing)
        np.testing.assert_array_equal(first.state, second.state)
        np.testing.assert_array_equal(first.covariance, second.covariance)
    assert with_platform.platform_gap == 'no angular velocity of the platform has come'


def test_rates_that_are_forgotten() -> None:
    """After a reset of the platform the rate is as unknown as at first sight, and soon known."""
    platform = PlatformRates()
    rate = np.array([0.0, 0.5, 0.0])
    turning(platform, 1.0, rate)
    tracker = Tracker(platform=platform)
    bearings = on_a_turning_base(30, rate)
    for bearing in bearings[:20]:
        tracker.update(bearing)
    platform.reset()
    assert tracker.at(bearings[20].stamp_ns) is None
    assert 'standard deviation' in tracker.reason
    for bearing in bearings[20:]:
        track = tracker.update(bearing)
    np.testing.assert_allclose(track.rate, [-500.0, 0.0], atol=20.0)
    assert tracker.refused == 0


def test_the_future_of_the_platform_is_uncertain() -> None:
    """Past its newest rate the deviation grows with what the platform may do."""
    platform = PlatformRates()
    turning(platform, 1.0, [0.0, 0.0, 0.0])
    tracker = Tracker(platform=platform, acceleration=100.0, stabilised_acceleration=1e-3)
    fed(tracker, steady(31, rate=0.0))
    last = platform.newest_ns
    assert last is not None
    known, guessed = present(tracker.at(last)), present(tracker.at(last + 100 * MS))
    grown = guessed.angle_covariance - known.angle_covariance
    # q t^3 / 3, besides what the rates' deviation adds.
    np.testing.assert_allclose(np.diag(grown), 100.0**2 * 0.1**3 / 3.0, rtol=0.02)


def test_pan_tilt() -> None:
    """A target at rest stays in the base while the camera turns, and moves in its picture."""
    pan_tilt = PanTiltAngles()
    tracker = Tracker(pan_tilt=pan_tilt, acceleration=10.0)
    direction = rays_of(np.array([[80.0, 30.0]]))[0]
    for index in range(30):
        pan_tilt.push(index * FRAME, 0.3 * 0.033 * index, -0.2 * 0.033 * index)
        seen = of_rays((pan_tilt.at(index * FRAME).T @ direction)[None])[0]
        azimuth, elevation = seen.tolist()
        track = tracker.update(Bearing(azimuth, elevation, COVARIANCE, index * FRAME))
    assert (track.azimuth, track.elevation) == pytest.approx((80.0, 30.0), abs=1e-3)
    np.testing.assert_allclose(track.rate, 0.0, atol=0.1)
    picture = present(tracker.seen_at(29 * FRAME))
    assert picture.state[:2] == pytest.approx(seen, abs=1e-3)
    earlier = of_rays((pan_tilt.at(29 * FRAME - MS).T @ direction)[None])[0]
    np.testing.assert_allclose(picture.rate, (seen - earlier) / 1e-3, atol=0.3)
    with pytest.raises(TrackingError, match='no direction in the base: the newest angle of pan'):
        tracker.update(Bearing(0.0, 0.0, COVARIANCE, 29 * FRAME + 201 * MS))
    assert tracker.at(29 * FRAME + 250 * MS) is not None
    assert tracker.seen_at(29 * FRAME + 250 * MS) is None
    assert 'the newest angle of pan' in tracker.reason


def test_the_error_of_the_joints_is_in_the_covariance() -> None:
    """A first bearing is as uncertain as it is and the joints are: 0.1 and 0.3 mrad."""
    pan_tilt = PanTiltAngles(sigma=0.3e-3)
    pan_tilt.push(0, 0.2, 0.1)
    track = Tracker(pan_tilt=pan_tilt).update(Bearing(1.0, 2.0, 0.1**2 * np.eye(2), 0))
    # The angles in the base, 200 mrad off: the azimuth's circle is smaller at 100 mrad up.
    sigmas = np.sqrt(np.diag(track.angle_covariance)) * (np.cos(0.102), 1.0)
    np.testing.assert_allclose(sigmas, np.hypot(0.1, 0.3), rtol=1e-4)
    # Past the newest sample also as the joints may have moved: 20 ms after 33 ms, 5 rad/s^2.
    pan_tilt = PanTiltAngles(acceleration=5.0)
    for stamp in (0, FRAME):
        pan_tilt.push(stamp, 0.0, 0.0)
    late = Tracker(pan_tilt=pan_tilt).update(Bearing(0.0, 0.0, COVARIANCE, FRAME + 20 * MS))
    strayed = 0.5 * 5e3 * 0.02 * (0.02 + 0.033)
    np.testing.assert_allclose(late.sigma, np.hypot(0.1, strayed), rtol=1e-6)
    with pytest.raises(TrackingError, match='sigma is nan rad; it must be 0 or more'):
        PanTiltAngles(sigma=np.nan)


@pytest.mark.parametrize('motion', list(MOTIONS))
def test_a_stabilised_target_is_as_good_as_from_a_still_camera(motion: str) -> None:
    """A resting light, an exact gyro: the error is that of a camera that does not move."""
    times = np.arange(0.0, 10.0, 1.0 / 30.0)
    ride = MOTIONS[motion].ride(11.0, 3)
    level = np.zeros((len(times), 2))
    truth = seen_from(ride, times, level)
    bearings, still = measured(times, truth, 0.1, 3), measured(times, level, 0.1, 3)
    platform = PlatformRates(memory=20.0)
    ticks = np.arange(0.0, 10.1, 1e-3)
    for stamp, rate in zip(nanoseconds(ticks), ride.rates(ticks)):
        platform.push(stamp, rate)
    errors = []
    for tracker, seen, true in (
        (Tracker(platform=platform, stabilised_acceleration=3.0), bearings, truth),
        (Tracker(acceleration=3.0), still, level),
    ):
        tracks = np.array([tracker.update(each).state[:2] for each in seen])
        errors.append((tracks - true)[30:])
    # The roll about the boresight mixes the noise of the axes: alike, not the same.
    moving, resting = (np.sqrt(np.mean(each**2)) for each in errors)
    assert resting < 0.07
    assert moving == pytest.approx(resting, rel=0.15)

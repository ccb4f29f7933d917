"""Directions at the pole and the seam, turned, moved and read as angles."""

from __future__ import annotations

from blob_tracker.tracking import PlatformRates, Tracker
from blob_tracker.tracking.direction import as_angles, moved, offset, placed, State, with_rates
from blob_tracker.types import Bearing
import numpy as np
import pytest
from support.consistency import of_rays

AHEAD = np.eye(3)
PLACES = [(0.0, 0.0), (300.0, -200.0), (-3100.0, 900.0), (1000.0, 1570.0), (0.0, -1565.0)]


@pytest.mark.parametrize(('azimuth', 'elevation'), PLACES)
def test_a_move_is_what_offset_measures(azimuth: float, elevation: float) -> None:
    """Both are the turn along the great circle, also by a large part of it."""
    axes = placed(azimuth, elevation, AHEAD)
    for right, up in ((1e-6, -2e-6), (3.0, 4.0), (-1000.0, 1500.0)):
        there = moved(axes, right, up)
        np.testing.assert_allclose(there @ there.T, np.eye(3), atol=1e-15)
        assert offset(axes, *there[:, 2]) == pytest.approx((right, up), rel=1e-9)
        turned = np.arccos(np.clip(axes[:, 2] @ there[:, 2], -1.0, 1.0))
        # The arc cosine of 1 less rounding is no better than its root.
        assert turned == pytest.approx(1e-3 * np.hypot(right, up), abs=3e-8)


@pytest.mark.parametrize(('azimuth', 'elevation'), PLACES)
def test_angles_and_derivatives_are_those_of_the_path(azimuth: float, elevation: float) -> None:
    """Beside differences of the angles along the path, at a spot 5 mrad from the pole too."""
    axes = placed(azimuth, elevation, AHEAD)
    motion = np.array([0.4, -0.7, 2.0, 3.0])
    scale = np.cos(1e-3 * elevation)
    state, _ = as_angles(State(axes, motion, np.eye(6)), AHEAD)
    assert state[:2] == pytest.approx((azimuth, elevation), abs=1e-6)
    h = 1e-2

    def at(t: float) -> np.ndarray:
        path = motion[:2] * t + motion[2:] * t**2 / 2
        return of_rays(moved(axes, *path)[None, :, 2])[0]

    before, middle, after = at(-h), at(0.0), at(h)
    rate = (after - before) / (2 * h)
    acceleration = (after - 2 * middle + before) / h**2
    # Third derivatives over h^2, and rounding of 1e-13 mrad over h^2.
    grain = np.array([1 / scale, 1.0])
    np.testing.assert_allclose(state[2:4] / grain, rate / grain, atol=1e-3)
    np.testing.assert_allclose(state[4:] / grain, acceleration / grain, atol=0.02)


@pytest.mark.parametrize(('azimuth', 'elevation'), PLACES[:3])
def test_covariance_is_carried_by_the_derivative(azimuth: float, elevation: float) -> None:
    """A bearing's covariance comes out as it went in, at any place and of any camera."""
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    track = Tracker().update(Bearing(azimuth, elevation, covariance))
    np.testing.assert_allclose(track.angle_covariance, covariance, rtol=1e-9)
    smallest, largest = np.linalg.eigvalsh(covariance)
    assert track.sigma <= np.sqrt(largest) * (1 + 1e-12)


@pytest.mark.parametrize('start', [(-3140.0, 0.0), (3141.0, 50.0), (100.0, 1545.0)])
def test_a_target_crosses_the_seam_and_the_pole(start: tuple[float, float]) -> None:
    """At 400 mrad/s along a great circle, that over the pole within 25 mrad: each is believed."""
    axes = placed(*start, AHEAD)
    tracker = Tracker()
    direction = (0.0, 1.0) if start[1] > 1500.0 else (1.0, 0.0)
    for index in range(60):
        path = 400.0 * index / 30.0
        ray = moved(axes, path * direction[0], path * direction[1])[:, 2]
        azimuth, elevation = of_rays(ray[None])[0]
        shrunk = max(np.cos(1e-3 * elevation), 1e-4)
        covariance = np.diag([(0.1 / shrunk)**2, 0.01])
        stamp = index * 33_333_333
        track = tracker.update(Bearing(azimuth, elevation, covariance, stamp))
        assert abs(track.azimuth) <= 1e3 * np.pi
        if index > 3:
            ahead = tracker.at(stamp + 33_333_333)
            assert ahead is not None
            there = moved(axes, *(np.array(direction) * (path + 400.0 / 30.0)))[:, 2]
            off = offset(placed(ahead.azimuth, ahead.elevation, AHEAD), *there)
            assert np.hypot(*off) < 0.02
    assert tracker.refused == 0


def test_rates_of_the_frame() -> None:
    """A target at rest moves against a turning base as its direction's derivative says."""
    rotation = np.array([0.03, -0.05, 0.2])
    state = State(placed(200.0, 100.0, AHEAD), np.zeros(2), np.eye(4))
    apparent, _ = as_angles(with_rates(state, rotation, -1.0, 5.0), AHEAD)
    ray = state.axes[:, 2]
    h = 1e-4
    angles = of_rays(np.array([ray - h * np.cross(rotation, ray),
                               ray + h * np.cross(rotation, ray)]))
    # Second derivatives cancel; third ones are below h^2.
    assert apparent[2:4] == pytest.approx((angles[0] - angles[1]) / (-2 * h) * -1.0, abs=1e-5)
    back = with_rates(with_rates(state, rotation, -1.0, 5.0), rotation, 1.0, 5.0)
    np.testing.assert_allclose(back.motion, 0.0, atol=1e-12)
    with_acceleration = State(state.axes, np.ones(4), np.ones((6, 6)))
    unsure = with_rates(with_acceleration, rotation, 1.0, 5.0)
    np.testing.assert_array_equal(unsure.motion[2:], 0.0)
    np.testing.assert_array_equal(unsure.covariance[4:], [[0] * 4 + [25, 0], [0] * 5 + [25]])
    np.testing.assert_array_equal(unsure.covariance[:4, :4], 1.0)


def test_a_turn_of_the_base_by_half_a_circle() -> None:
    """The target stays where it is in the world, and goes round in the base."""
    platform = PlatformRates()
    for index in range(61):
        platform.push(index * 10_000_000, [0.0, np.pi / 0.6, 0.0])
    tracker = Tracker(platform=platform, stabilised_acceleration=1.0)
    tracker.update(Bearing(0.0, 300.0, 0.01 * np.eye(2), 0))
    for index in range(1, 19):
        turned = np.pi / 0.6 * index / 30.0
        azimuth = np.angle(np.exp(-1j * turned))
        stamp = round(index * 1e9 / 30.0)
        tracker.update(Bearing(1e3 * azimuth, 300.0, 0.01 * np.eye(2), stamp))
    assert tracker.refused == 0
    track = tracker.at(600_000_000)
    assert track is not None
    assert abs(track.azimuth) == pytest.approx(1e3 * np.pi, abs=1e-3)
    assert track.elevation == pytest.approx(300.0, abs=1e-3)
    np.testing.assert_allclose(track.rate, 0.0, atol=0.01)
    seen = tracker.seen_at(600_000_000)
    assert seen is not None
    np.testing.assert_allclose(seen.rate, [-1e3 * np.pi / 0.6, 0.0], atol=0.02)

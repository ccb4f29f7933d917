"""Bearings in any order, and impossible ones."""

from __future__ import annotations

from typing import Any

from blob_tracker.tracking import (
    MODELS, PanTiltAngles, PlatformRates, StampJump, Tracker, TrackingError,
)
from blob_tracker.types import Bearing
import numpy as np
import pytest
from support.steady_bearings import COVARIANCE, fed, FRAME, MS, present, steady


@pytest.mark.parametrize('model', list(MODELS))
def test_a_steady_target_is_predicted(model: str) -> None:
    """To rounding, where the motion is the model's and the bearings have no noise."""
    tracker = Tracker(model, acceleration=1.0, jerk=1.0)
    fed(tracker, steady(40))
    ahead = present(tracker.at(39 * FRAME + 100 * MS))
    assert ahead.stamp_ns == 39 * FRAME + 100 * MS
    # A prior of no motion is weighed in, with the weight of 1e-10 of what forty bearings tell.
    assert ahead.azimuth == pytest.approx(50.0 * (39 * 0.033 + 0.1), abs=1e-3)
    assert ahead.elevation == pytest.approx(0.0, abs=1e-6)
    assert ahead.rate == pytest.approx([50.0, 0.0], abs=1e-2)
    assert ahead.state.shape == (MODELS[model].size,)
    assert ahead.covariance.shape == (MODELS[model].size,) * 2
    assert ahead.angle_covariance.shape == ahead.rate_covariance.shape == (2, 2)
    assert tracker.reason == ''
    assert (tracker.bearings, tracker.refused, tracker.late, tracker.begun) == (40, 0, 0, 1)


@pytest.mark.parametrize('model', list(MODELS))
@pytest.mark.parametrize('stabilised', [False, True])
def test_order_does_not_matter(model: str, stabilised: bool) -> None:
    """Late bearings, with wild ones and a leap among them, leave the same track, bit for bit."""
    random = np.random.default_rng(8)
    bearings = [
        Bearing(20.0 * np.sin(index / 9.0) + 500.0 * (index in (20, 31) or index > 60),
                0.1 * random.standard_normal(), COVARIANCE, index * FRAME)
        for index in range(80)
    ]
    shuffled = [bearings[index] for index in np.argsort(np.arange(80) + random.uniform(0, 8, 80))]
    assert shuffled != bearings
    ends = []
    for order in (bearings, shuffled):
        platform = None
        if stabilised:
            platform = PlatformRates(memory=10.0)
            for stamp in range(0, 80 * FRAME, 10 * MS):
                platform.push(stamp, [0.1, 0.2, 0.3], 1e-6)
        tracker = Tracker(model, platform=platform)
        fed(tracker, order)
        ends.append(tracker)
    assert ends[0].late == 0 < ends[1].late
    for stamp in range(60 * FRAME, 82 * FRAME, 7 * MS):
        first, second = (each.at(stamp) for each in ends)
        assert (first is None) == (second is None)
        if first is not None and second is not None:
            np.testing.assert_array_equal(first.state, second.state)
            np.testing.assert_array_equal(first.covariance, second.covariance)


def test_the_past_is_told_by_the_bearings_until_then() -> None:
    """Within the memory; before it there is no answer."""
    tracker = Tracker()
    then = []
    for bearing in steady(60):
        then.append(tracker.update(bearing))
    np.testing.assert_array_equal(present(tracker.at(50 * FRAME)).state, then[50].state)
    assert tracker.at(10 * FRAME) is None
    assert 'before the oldest bearing' in tracker.reason


def test_stamps() -> None:
    """Equal ones are refused, and those from before the memory; far forward is a new track."""
    tracker = Tracker()
    bearings = steady(60)
    fed(tracker, bearings)
    before = present(tracker.at(60 * FRAME))
    with pytest.raises(TrackingError, match='there is a bearing with the stamp'):
        tracker.update(bearings[50])
    with pytest.raises(StampJump, match='before the newest one'):
        tracker.update(bearings[3])
    np.testing.assert_array_equal(present(tracker.at(60 * FRAME)).state, before.state)
    assert tracker.begun == 1
    track = tracker.update(Bearing(-700.0, 0.0, COVARIANCE, 10**12))
    assert tracker.begun == 2
    assert track.azimuth == pytest.approx(-700.0)
    tracker.reset()
    assert tracker.at(10**12) is None
    assert tracker.reason == 'no bearing has come'
    assert tracker.stamp_ns is None
    tracker.update(bearings[3])
    assert tracker.stamp_ns == bearings[3].stamp_ns


@pytest.mark.parametrize(('covariance', 'azimuth', 'elevation'), [
    (np.zeros((2, 2)), 0.0, 0.0),
    (np.diag([0.01, 0.0]), 0.0, 0.0),
    (np.diag([0.01, -0.01]), 0.0, 0.0),
    (np.diag([np.nan, 0.01]), 0.0, 0.0),
    (np.diag([0.01, np.inf]), 0.0, 0.0),
    (np.array([[0.01, 0.002], [0.001, 0.01]]), 0.0, 0.0),
    (np.array([[0.01, np.nan], [np.nan, 0.01]]), 0.0, 0.0),
    (np.array([[0.01, 0.02], [0.02, 0.01]]), 0.0, 0.0),
    (np.array([[0.01, 0.01], [0.01, 0.01]]), 0.0, 0.0),
    (np.array([0.01, 0.01]), 0.0, 0.0),
    (np.diag([0.01, 1e-11]), 0.0, 0.0),
    (np.diag([1.1e7, 0.01]), 0.0, 0.0),
    (COVARIANCE, np.nan, 0.0),
    (COVARIANCE, 0.0, np.inf),
    (COVARIANCE, 0.0, 1571.0),
])
def test_impossible_bearings_are_refused(
    covariance: np.ndarray, azimuth: float, elevation: float
) -> None:
    """With the reason, and the track is what it was."""
    tracker = Tracker()
    fed(tracker, steady(10))
    before = present(tracker.at(10 * FRAME))
    with pytest.raises(TrackingError, match='covariance is|azimuth and elevation are'):
        tracker.update(Bearing(azimuth, elevation, covariance, 10 * FRAME))
    np.testing.assert_array_equal(present(tracker.at(10 * FRAME)).covariance, before.covariance)


@pytest.mark.parametrize(('name', 'value'), [
    ('acceleration', 0.0), ('jerk', np.nan), ('stabilised_acceleration', -1.0),
    ('stabilised_jerk', np.inf), ('gate_sigma', 0.0), ('coast', np.nan), ('max_sigma', 0.0),
])
def test_impossible_parameters_are_refused(name: str, value: float) -> None:
    """Each by its name."""
    impossible: dict[str, Any] = {name: value}
    with pytest.raises(TrackingError, match=f'{name} is {value}'):
        Tracker(**impossible)


def test_unknown_model_is_refused() -> None:
    """With those that there are."""
    with pytest.raises(TrackingError, match='constant_velocity, constant_acceleration'):
        Tracker('constant')


@pytest.mark.parametrize('stamp', [2**63, -2**63 - 1, 2**200])
def test_stamps_of_no_clock_are_refused(stamp: int) -> None:
    """Of bearings, rates and joints; what was known stays."""
    platform, pan_tilt = PlatformRates(), PanTiltAngles()
    platform.push(0, np.zeros(3))
    pan_tilt.push(0, 0.0, 0.0)
    tracker = Tracker(platform=platform, pan_tilt=pan_tilt)
    tracker.update(Bearing(0.0, 0.0, COVARIANCE, 0))
    for push in (
        lambda: tracker.update(Bearing(0.0, 0.0, COVARIANCE, stamp)),
        lambda: platform.push(stamp, np.zeros(3)),
        lambda: pan_tilt.push(stamp, 0.0, 0.0),
    ):
        with pytest.raises(TrackingError, match='within 146 years'):
            push()
    tracker.update(Bearing(0.0, 0.0, COVARIANCE, 10 * MS))
    assert tracker.bearings == 2


@pytest.mark.parametrize('seed', range(20))
def test_whatever_comes_the_track_is_one(seed: int) -> None:
    """Wild bearings, covariances, stamps, rates and joints: a true covariance, or silence."""
    random = np.random.default_rng(seed)
    platform = PlatformRates() if seed % 3 else None
    pan_tilt = PanTiltAngles() if seed % 5 == 0 else None
    tracker = Tracker(
        list(MODELS)[seed % 2], acceleration=10**random.uniform(-2, 6),
        jerk=10**random.uniform(-2, 6), gate_sigma=10**random.uniform(0, 1.5), coast=1.0,
        max_sigma=1e3, platform=platform, pan_tilt=pan_tilt,
    )
    now, told = 10**18, 0
    for _ in range(150):
        now += int(10**random.uniform(5, 8))
        stamp = now - int(random.choice([0.0, 0.0, 1e7, 1e8, 2e9]) * random.random())
        try:
            if platform is not None:
                platform.push(stamp, random.normal(size=3) * random.choice([0.01, 1, 50]), 1e-4)
            if pan_tilt is not None:
                pan_tilt.push(stamp, *random.normal(size=2))
        except TrackingError:
            pass  # a stamp from before the memory
        wild = random.random() < 0.2
        azimuth, elevation = random.uniform(-1, 1, 2) * ((4000, 1570.79) if wild else (10, 10))
        deviations = 10**random.uniform(-5, 3, 2)
        correlation = random.uniform(-1, 1) * deviations.prod()
        covariance = np.diag(deviations**2) + correlation * (1 - np.eye(2))
        tracks = []
        try:
            tracks.append(tracker.update(Bearing(azimuth, elevation, covariance, stamp)))
        except TrackingError as error:
            assert str(error)
        tracks += [tracker.at(stamp + int(random.uniform(-1e9, 1e9))),
                   tracker.seen_at(stamp + int(random.uniform(0, 2e8)))]
        for track in tracks:
            if track is None:
                continue
            told += 1
            assert np.isfinite(track.state).all()
            np.testing.assert_array_equal(track.covariance, track.covariance.T)
            scale = np.sqrt(np.diag(track.covariance))
            # Eigenvalues of correlations; rounding of the solver.
            correlations = track.covariance / np.outer(scale, scale)
            assert np.linalg.eigvalsh(correlations).min() > -1e-14
            assert abs(track.azimuth) <= 1e3 * np.pi and abs(track.elevation) <= 500 * np.pi
    assert told > 50

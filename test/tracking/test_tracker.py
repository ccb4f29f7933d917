"""Bearings in any order, wild ones and impossible ones; the loss rule, and the platform."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import (
    MODELS,
    PanTiltAngles,
    PlatformRates,
    StampJump,
    Track,
    Tracker,
    TrackingError,
)
from blob_tracker.types import Bearing
import numpy as np
import pytest
from support.consistency import measured, nanoseconds, of_rays, rays_of, seen_from

MS = 1_000_000  # ns
FRAME = 33 * MS
COVARIANCE = 0.01 * np.eye(2)


def steady(count: int, *, rate: float = 50.0, first: int = 0) -> list[Bearing]:
    """Return bearings to the right at a rate in mrad/s, without noise."""
    return [
        Bearing(rate * 1e-9 * stamp, 0.0, COVARIANCE, stamp)
        for stamp in range(first * FRAME, (first + count) * FRAME, FRAME)
    ]


def fed(tracker: Tracker, bearings: Sequence[Bearing]) -> list[str]:
    """Give bearings to a tracker; return why each was refused, empty where it was not."""
    reasons = []
    for bearing in bearings:
        try:
            tracker.update(bearing)
            reasons.append('')
        except TrackingError as error:
            reasons.append(str(error))
    return reasons


def present(track: Track | None) -> Track:
    """Return a track that must be there."""
    assert track is not None
    return track


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


def test_silence_after_coast() -> None:
    """And the next bearing starts anew, wherever it is."""
    tracker = Tracker(coast=0.2, acceleration=10.0)
    fed(tracker, steady(30))
    last = 29 * FRAME
    assert tracker.at(last + 200 * MS) is not None
    assert tracker.at(last + 201 * MS) is None
    assert tracker.reason == 'the last bearing is 0.201 s ago; coast is 0.2 s'
    track = tracker.update(Bearing(-900.0, 50.0, COVARIANCE, last + 300 * MS))
    assert (track.azimuth, track.elevation) == pytest.approx((-900.0, 50.0))
    assert tracker.begun == 2


def test_two_bearings_are_no_track_yet() -> None:
    """The third is the first that can contradict the rate that they give."""
    tracker = Tracker(max_sigma=5.0)
    for count, bearing in enumerate(steady(3), start=1):
        assert tracker.update(bearing).sigma <= 0.1 * (1.0 + 1e-6)
        assert (tracker.at(bearing.stamp_ns + FRAME) is None) == (count < 3)
        if count < 3:
            assert tracker.seen_at(bearing.stamp_ns) is None
            assert tracker.reason == f'only {count} of the 3 bearings that must agree have come'


@pytest.mark.parametrize('model', list(MODELS))
@pytest.mark.parametrize('gap', [0, 200, 450, 600])
def test_a_false_bearing_at_the_beginning_or_after_a_gap(model: str, gap: int) -> None:
    """150 mrad off a target at rest: it is not told, nor is the leap from it as a rate."""
    tracker = Tracker(model, max_sigma=5.0)
    first = 0
    if gap:
        fed(tracker, steady(20, rate=0.0))
        first = 19 * FRAME + gap * MS
    told = 0
    fed(tracker, [Bearing(150.0, 0.0, COVARIANCE, first)])
    for index in range(10):
        if index:
            fed(tracker, [Bearing(0.0, 0.0, COVARIANCE, first + index * FRAME)])
        for ahead in (0, 30, 60):
            track = tracker.at(first + index * FRAME + ahead * MS)
            if track is not None:
                told += 1
                # What is told is within what it says of itself, by far.
                assert abs(track.azimuth) < 5.0
    assert told >= 9


def test_silence_above_the_largest_sigma() -> None:
    """And the next bearing starts anew, wherever it is."""
    tracker = Tracker(max_sigma=5.0)
    fed(tracker, steady(20))
    last = 19 * FRAME
    assert tracker.at(last + 60 * MS) is not None
    assert tracker.at(last + 300 * MS) is None
    assert tracker.reason.startswith('the standard deviation of the direction is ')
    # Within five of its deviations, which are great by then.
    track = tracker.update(Bearing(80.0, 0.0, COVARIANCE, last + 300 * MS))
    assert (track.azimuth, track.elevation) == pytest.approx((80.0, 0.0))
    assert tracker.begun == 2
    assert tracker.at(last + 300 * MS) is None
    assert tracker.reason.startswith('only 1 of the 3 bearings')


def test_order_does_not_matter_where_a_track_ends_by_its_sigma() -> None:
    """Late bearings on both sides of the end leave the same track, bit for bit."""
    random = np.random.default_rng(12)
    stamps = 10 * MS * np.cumsum(random.choice([1, 2, 3, 25], 120, p=[0.5, 0.3, 0.1, 0.1]))
    bearings = [
        Bearing(3.0 * np.sin(1e-9 * stamp), 0.1 * random.standard_normal(), COVARIANCE, int(stamp))
        for stamp in stamps
    ]
    shuffled = [bearings[k] for k in np.argsort(np.arange(120) + random.uniform(0, 4, 120))]
    ordered, disordered = Tracker(max_sigma=5.0), Tracker(max_sigma=5.0)
    assert not any(fed(ordered, bearings) + fed(disordered, shuffled))
    assert ordered.begun > 5 and disordered.late > 10
    told = 0
    for stamp in range(int(stamps[-1]) - 900 * MS, int(stamps[-1]) + 20 * MS, 5 * MS):
        first, second = ordered.at(stamp), disordered.at(stamp)
        assert (first is None) == (second is None)
        if first is not None and second is not None:
            told += 1
            np.testing.assert_array_equal(first.state, second.state)
            np.testing.assert_array_equal(first.covariance, second.covariance)
    assert told > 20


def test_limits_are_set_while_it_follows() -> None:
    """The track stays; what is believed and told changes; an impossible one changes nothing."""
    tracker = Tracker(acceleration=10.0)
    bearings = steady(31)
    fed(tracker, bearings[:30])
    last = 29 * FRAME
    told = present(tracker.at(last + 300 * MS))
    tracker.set_limits(coast=0.2)
    assert tracker.at(last + 300 * MS) is None
    tracker.set_limits(coast=0.5, max_sigma=0.01)
    assert tracker.at(last + 300 * MS) is None
    assert 'max_sigma' in tracker.reason
    tracker.set_limits(max_sigma=20.0)
    np.testing.assert_array_equal(present(tracker.at(last + 300 * MS)).state, told.state)
    for name, value in (('gate_sigma', -1.0), ('coast', np.nan), ('max_sigma', np.inf)):
        with pytest.raises(TrackingError, match=f'{name} is {value}'):
            tracker.set_limits(**{'gate_sigma': 1.0, 'coast': 1.0, 'max_sigma': 1.0, name: value})
    assert (tracker.gate_sigma, tracker.coast, tracker.max_sigma) == (5.0, 0.5, 20.0)
    off = Bearing(bearings[30].azimuth + 1.0, 0.0, COVARIANCE, bearings[30].stamp_ns)
    assert fed(tracker, [off]) != ['']
    tracker.set_limits(gate_sigma=100.0)
    assert fed(tracker, [Bearing(off.azimuth, 0.0, COVARIANCE, off.stamp_ns + MS)]) == ['']
    assert tracker.begun == 1


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


def test_one_wild_bearing_is_refused() -> None:
    """The track goes on as if it had not come."""
    tracker, undisturbed = Tracker(), Tracker()
    bearings = steady(30)
    wild = Bearing(400.0, -100.0, COVARIANCE, 20 * FRAME + MS)
    assert any(fed(tracker, [*bearings[:21], wild]))
    fed(undisturbed, bearings[:21])
    np.testing.assert_allclose(
        present(tracker.at(21 * FRAME)).state, present(undisturbed.at(21 * FRAME)).state
    )
    assert not any(fed(tracker, bearings[21:]))
    assert (tracker.refused, tracker.begun) == (1, 1)


def test_gate_lets_true_bearings_through() -> None:
    """By a chi-square of two degrees of freedom: with probability 1 - exp(-gate_sigma^2 / 2)."""
    gate_sigma = 2.0
    times = 0.033 * np.arange(3000.0)
    bearings = measured(times, np.zeros((3000, 2)), 0.1, 4)
    tracker = Tracker(acceleration=1.0, gate_sigma=gate_sigma)
    refused = sum(map(bool, fed(tracker, bearings))) / 3000
    # Binomial, 4 standard deviations.
    assert refused == pytest.approx(np.exp(-gate_sigma**2 / 2), abs=4 * np.sqrt(0.135 / 3000))


@pytest.mark.parametrize('model', list(MODELS))
def test_a_leap_of_30_degrees(model: str) -> None:
    """
    Two bearings that agree silence the track, the third replaces it; nothing runs away.

    Whatever is told is the old track's path or the new one's.
    """
    tracker = Tracker(model)
    leap = np.radians(30.0) * 1e3
    before = steady(30)
    after = [
        Bearing(each.azimuth + leap, each.elevation, COVARIANCE, each.stamp_ns)
        for each in steady(20, first=30)
    ]
    fed(tracker, before)
    told = []
    for count, bearing in enumerate(after):
        reason, = fed(tracker, [bearing])
        assert bool(reason) == (count < 2)
        for ahead in range(0, 60, 7):
            stamp = bearing.stamp_ns + ahead * MS
            track = tracker.at(stamp)
            told.append(track is not None)
            if track is not None:
                straight = 50.0 * 1e-9 * stamp
                # Three bearings tell a rate to 0.1 / 0.06 mrad/s and an acceleration to 200.
                assert min(abs(track.azimuth - straight), abs(track.azimuth - straight - leap)) < 1
        if count == 1:
            assert not told[-1]
            assert tracker.reason == (
                'the last 2 bearings agree with each other and not with the track'
            )
    assert told[-1]
    assert (tracker.refused, tracker.begun) == (2, 2)


def test_wild_bearings_that_do_not_agree_change_nothing() -> None:
    """However many there are, until the track has coasted out."""
    tracker = Tracker(coast=0.5, acceleration=20.0)
    fed(tracker, steady(30))
    for index in range(30, 44):
        wild = Bearing(-900.0 + 400.0 * (index % 5), -300.0, COVARIANCE, index * FRAME)
        reason, = fed(tracker, [wild])
        assert 'standard deviations from where the track expects it' in reason
        track = present(tracker.at(index * FRAME))
        assert track.azimuth == pytest.approx(50.0 * 0.033 * index, abs=0.2)
    assert fed(tracker, steady(1, first=44)) == ['']
    assert tracker.begun == 1


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


def test_a_track_that_can_never_be_sure_says_so() -> None:
    """At 5 Hz and 300 mrad/s^2: sqrt(q t^3 / 3) is 15 mrad, and the rate's deviation the same."""
    tracker = Tracker(max_sigma=10.0)
    for index in range(10):
        tracker.update(Bearing(0.0, 0.0, COVARIANCE, 200 * MS * index))
        assert tracker.at(200 * MS * index) is None or index % 3 == 2
    assert tracker.at(200 * MS * 9) is None
    assert 'only 1 of the 3 bearings' in tracker.reason
    assert 'the track before was sure to 21.2 mrad' in tracker.reason
    assert 'max_sigma is 10' in tracker.reason


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

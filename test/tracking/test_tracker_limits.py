"""The loss rule, and bearings that are too far off: when there is a track, and when it ends."""

from __future__ import annotations

from blob_tracker.tracking import MODELS, Tracker, TrackingError
from blob_tracker.types import Bearing
import numpy as np
import pytest
from support.consistency import measured
from support.steady_bearings import COVARIANCE, fed, FRAME, MS, present, steady


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

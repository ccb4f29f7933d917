"""Two cameras that run freely: pairs of one instant, whatever the order of arrival."""

from __future__ import annotations

from itertools import permutations

from blob_tracker.tracking import CameraPose, Sight
from blob_tracker.tracking.simultaneous import MOST, Simultaneous
from blob_tracker.types import Bearing
import numpy as np
import pytest

MS = 1_000_000
POSE = CameraPose(np.zeros(3))


def at(ms: float) -> Sight:
    """Return what a camera sees of a light that moves by 1 mrad in 1 ms."""
    return Sight(Bearing(ms, -ms, 0.01 * np.eye(2), 10**12 + round(ms * MS)), POSE)


def test_pairs_are_of_one_instant_and_one_direction() -> None:
    """30 Hz beside 100 Hz: each of the slow camera but the first, where the other stands still."""
    pairing = Simultaneous(0.1, 0.0)
    both = sorted(
        [(ms, True) for ms in np.arange(5.0, 400.0, 33.3)]
        + [(ms, False) for ms in np.arange(7.0, 420.0, 10.0)]
    )
    pairs = []
    for ms, first in both:
        pairs += (pairing.first if first else pairing.second)(at(ms))
    assert len(pairs) == len(np.arange(5.0, 400.0, 33.3)) - 1
    assert pairing.skipped == 1
    for one, other in pairs:
        assert one.stamp_ns == other.stamp_ns
        assert other.bearing.azimuth == pytest.approx(one.bearing.azimuth)
        assert other.bearing.elevation == pytest.approx(one.bearing.elevation)
    assert pairing.interval == pytest.approx(0.01)


def test_the_order_of_arrival_changes_nothing() -> None:
    """Between the two cameras; each of them in its own order."""
    firsts, seconds = [at(10), at(30), at(50)], [at(5), at(25), at(45), at(65)]
    results = set()
    for order in set(permutations('fffssss')):
        pairing = Simultaneous(0.1, 100.0)
        waiting = {'f': iter(firsts), 's': iter(seconds)}
        pairs = []
        for letter in order:
            take = pairing.first if letter == 'f' else pairing.second
            pairs += take(next(waiting[letter]))
        results.add(tuple(
            (one.bearing.azimuth, other.bearing.azimuth, *other.bearing.covariance.flat)
            for one, other in pairs
        ))
    assert len(results) == 1
    assert len(results.pop()) == 3


def test_equal_stamps_need_no_interpolation() -> None:
    """Cameras with one trigger: at once, and the very sight."""
    pairing = Simultaneous(0.1, 1e6)
    assert pairing.first(at(10)) == []
    second = at(10)
    (_, other), = pairing.second(second)
    assert other is second
    assert pairing.interval == 0.0


def test_too_wide_a_gap_gives_no_pair() -> None:
    """The second camera lost the light for longer than is to be bridged."""
    pairing = Simultaneous(0.05, 0.0)
    pairing.second(at(0))
    assert pairing.first(at(10)) == []
    assert pairing.second(at(51)) == []
    assert (pairing.skipped, pairing.interval) == (1, pytest.approx(0.051))
    pairing.first(at(60))
    assert len(pairing.second(at(101))) == 1


def test_stamps_that_do_not_grow_are_refused() -> None:
    """One that is late is left out; a jump back begins afresh."""
    pairing = Simultaneous(0.05, 0.0)
    pairing.second(at(0))
    pairing.first(at(10))
    for late in (10, 2):
        with pytest.raises(ValueError, match='ray left out'):
            pairing.first(at(late))
    assert len(pairing.second(at(20))) == 1
    with pytest.raises(ValueError, match='jumped back by 5.020 s; starting afresh'):
        pairing.second(at(-5000))
    assert pairing.first(at(-4990)) == []
    assert len(pairing.second(at(-4980))) == 1


def test_what_is_of_before_a_jump_of_the_clock_is_forgotten() -> None:
    """And what has jumped already stays."""
    pairing = Simultaneous(0.05, 0.0)
    pairing.second(at(0))
    pairing.first(at(5000))
    pairing.forget(at(2500).stamp_ns)
    pairing.first(at(10))
    assert len(pairing.second(at(20))) == 1


def test_what_waits_in_vain_does_not_pile_up() -> None:
    """One camera is silent for an hour."""
    pairing = Simultaneous(0.05, 0.0)
    for step in range(3 * MOST):
        pairing.first(at(step))
    assert len(pairing.second(at(3 * MOST))) == 0
    assert pairing.skipped == MOST

"""Cameras that run freely: bearings of one instant, whatever the order of arrival."""

from __future__ import annotations

from itertools import permutations

from blob_tracker.tracking import CameraPose, Sight
from blob_tracker.tracking.simultaneous import Instant, MOST, Simultaneous
from blob_tracker.types import Bearing
import numpy as np
import pytest

MS = 1_000_000
POSE = CameraPose(np.zeros(3))


def at(ms: float) -> Sight:
    """Return what a camera sees of a light that moves by 1 mrad in 1 ms."""
    return Sight(Bearing(ms, -ms, 0.01 * np.eye(2), 10**12 + round(ms * MS)), POSE)


def played(
    pairing: Simultaneous, *stamps: np.ndarray | list[float]
) -> list[Instant]:
    """Return what comes of cameras that see at these instants, ms, as they come."""
    due = sorted((ms, camera) for camera, of in enumerate(stamps) for ms in of)
    return [each for ms, camera in due for each in pairing.take(camera, at(ms))]


def cameras(found: list[Instant]) -> list[tuple[int, ...]]:
    """Return the cameras of each instant."""
    return [each.cameras for each in found]


def test_pairs_are_of_one_instant_and_one_direction() -> None:
    """30 Hz beside 100 Hz: each of the slow camera but the first, where the other stands still."""
    pairing = Simultaneous(2, 0.1, 0.0)
    slow = np.arange(5.0, 400.0, 33.3)
    pairs = played(pairing, slow, np.arange(7.0, 420.0, 10.0))
    assert len(pairs) == len(slow) - 1
    assert (pairing.skipped, pairing.unseen) == (0, 1)
    for _, (one, other), _ in pairs:
        assert one.stamp_ns == other.stamp_ns
        assert other.bearing.azimuth == pytest.approx(one.bearing.azimuth)
        assert other.bearing.elevation == pytest.approx(one.bearing.elevation)
    assert pairing.interval == pytest.approx(0.01)


def test_any_cameras_that_see_the_light_give_an_instant() -> None:
    """Three of them, each in the dark for a while; the stamps are those of the first that sees."""
    pairing = Simultaneous(3, 0.1, 0.0)
    stamps = [np.arange(first, 1200.0, 20.0) for first in (0.0, 7.0, 13.0)]
    dark = (300.0, 500.0), (600.0, 800.0), (900.0, 1100.0)
    found = played(pairing, *(
        each[(each < begin) | (each > end)] for each, (begin, end) in zip(stamps, dark)
    ))
    for instant in found:
        assert len({each.stamp_ns for each in instant.sights}) == 1
        assert len({round(each.bearing.azimuth, 6) for each in instant.sights}) == 1
    of = dict(zip((round(each.sights[0].bearing.azimuth) for each in found), cameras(found)))
    assert of[200] == of[580] == of[1120] == (0, 1, 2)
    assert of[407] == (1, 2)  # by the stamps of the second
    assert of[700] == (0, 2)
    assert of[1000] == (0, 1)
    instants = list(of)
    assert instants == sorted(instants)
    # Every 20 ms, but for the time between the last ray of one and the first of the next.
    assert np.diff(instants).max() <= 40
    assert pairing.late == [0, 0, 0]


@pytest.mark.parametrize('count', [2, 3])
def test_the_order_of_arrival_changes_nothing(count: int) -> None:
    """Between the cameras; each of them in its own order."""
    stamps = ([10, 30, 50], [5, 25, 45, 65]) if count == 2 else ([10, 30], [5, 35, 45], [8, 28])
    letters = ''.join(str(camera) * len(each) for camera, each in enumerate(stamps))
    results = set()
    for order in set(permutations(letters)):
        pairing = Simultaneous(count, 0.1, 100.0)
        waiting = [iter(each) for each in stamps]
        found = []
        for camera in reversed(range(count)):  # who has never come is not waited for
            assert pairing.take(camera, at(-2 - camera)) == []
        for letter in order:
            found += pairing.take(int(letter), at(next(waiting[int(letter)])))
        assert not any(pairing.late)
        results.add(tuple(
            (camera, sight.bearing.azimuth, *sight.bearing.covariance.flat, *of.strayed.flat)
            for of in found for camera, sight in zip(of.cameras, of.sights)
        ))
    assert len(results) == 1
    assert len(results.pop()) == 8


def test_equal_stamps_need_no_interpolation() -> None:
    """Cameras with one trigger: at once, and the very bearing."""
    pairing = Simultaneous(3, 0.1, 1e6)
    for camera in range(3):
        pairing.take(camera, at(0))
    assert pairing.take(0, at(10)) == []
    second, third = at(10), at(10)
    assert pairing.take(2, third) == []
    (_, (_, other, last), strayed), = pairing.take(1, second)
    assert not strayed.any()
    assert other is second
    assert last is third
    assert pairing.interval == 0.0


def test_too_wide_a_gap_gives_no_pair() -> None:
    """The second camera lost the light for longer than is to be bridged."""
    pairing = Simultaneous(2, 0.05, 0.0)
    pairing.take(1, at(0))
    assert pairing.take(0, at(10)) == []
    assert pairing.take(1, at(51)) == []
    assert (pairing.skipped, pairing.gap) == (1, pytest.approx(0.051))
    pairing.take(0, at(60))
    assert len(pairing.take(1, at(101))) == 1
    assert pairing.interval == pytest.approx(0.05)
    assert (pairing.skipped, pairing.unseen, pairing.gap) == (1, 0, pytest.approx(0.051))


def test_instants_that_the_others_do_not_see_yet_are_no_gap() -> None:
    """The second begins later, near the first's rays or not: no interval would help."""
    pairing = Simultaneous(2, 0.1, 0.0)
    for ms in (0, 10, 20):
        pairing.take(0, at(ms))
    assert len(pairing.take(1, at(15))) == 0
    assert len(pairing.take(1, at(25))) == 1
    assert (pairing.unseen, pairing.skipped) == (2, 0)
    assert np.isnan(pairing.gap)


def test_the_gap_that_is_told_is_the_one_about_the_ray() -> None:
    """Not one that lies before it, which is narrower than what is bridged."""
    pairing = Simultaneous(2, 0.05, 0.0)
    for ms in (-5, 3):
        pairing.take(1, at(ms))
    pairing.take(0, at(10))
    pairing.take(1, at(90))
    assert (pairing.skipped, pairing.gap) == (1, pytest.approx(0.087))


def test_a_camera_that_is_slower_than_the_interval_gives_the_instants_alone() -> None:
    """5 Hz beside two of 50 Hz: these go on between its rays."""
    found = played(
        Simultaneous(3, 0.1, 0.0), np.arange(3.0, 900.0, 200.0), np.arange(0.0, 900.0, 20.0),
        np.arange(10.0, 900.0, 20.0),
    )
    assert cameras(found).count((0, 1, 2)) == 4  # before the first ray of the last it is alone
    assert cameras(found).count((1, 2)) == 40  # the last wait for it


def test_rays_that_come_too_late_are_counted() -> None:
    """The third camera's are half a second older than the others' as they come."""
    pairing = Simultaneous(3, 0.1, 0.0)
    found = []
    for ms in range(0, 2000, 20):
        found += pairing.take(0, at(ms)) + pairing.take(1, at(ms))
        if ms >= 500:
            found += pairing.take(2, at(ms - 500))
    assert set(cameras(found)) == {(0, 1)}
    assert len(found) == 100
    assert pairing.late == [0, 0, 75]


@pytest.mark.parametrize('ahead', range(4))
def test_a_camera_whose_clock_is_ahead_makes_no_other_late(ahead: int) -> None:
    """By 0.3 s, one of four: the other three go on between them."""
    pairing = Simultaneous(4, 0.1, 0.0)
    found = []
    for ms in range(0, 2000, 20):
        for camera in range(4):
            stamp = ms + 5 * camera + 300 * (camera == ahead)
            found += pairing.take(camera, at(stamp))
    others = {0, 1, 2, 3} - {ahead}
    assert sum(others <= set(each) for each in cameras(found)) > 80
    assert pairing.late == [0, 0, 0, 0]


def test_a_pair_is_waited_for_however_late_it_is() -> None:
    """Of two cameras one is a second late: there is nothing to be given without it."""
    pairing = Simultaneous(2, 0.1, 0.0)
    for ms in range(0, 1000, 20):
        assert pairing.take(0, at(ms)) == []
    assert sum(len(pairing.take(1, at(ms))) for ms in range(0, 1000, 20)) == 50
    assert pairing.late == [0, 0]


def test_stamps_that_do_not_grow_are_refused() -> None:
    """One that is late is left out; a jump back begins afresh."""
    pairing = Simultaneous(2, 0.05, 0.0)
    pairing.take(1, at(0))
    pairing.take(0, at(10))
    for late in (10, 2):
        with pytest.raises(ValueError, match='ray left out'):
            pairing.take(0, at(late))
    assert len(pairing.take(1, at(20))) == 1
    with pytest.raises(ValueError, match='jumped back by 5.020 s; starting again'):
        pairing.take(1, at(-5000))
    assert pairing.take(0, at(-4990)) == []
    assert len(pairing.take(1, at(-4980))) == 1


def test_what_is_of_before_a_jump_of_the_clock_is_forgotten() -> None:
    """And what has jumped already stays."""
    pairing = Simultaneous(2, 0.05, 0.0)
    pairing.take(1, at(0))
    pairing.take(0, at(5000))
    pairing.forget(at(2500).stamp_ns)
    pairing.take(0, at(10))
    assert len(pairing.take(1, at(20))) == 1


def test_a_camera_is_left_out() -> None:
    """All that came of it is as if it had never been."""
    pairing = Simultaneous(3, 0.05, 0.0)
    for camera in range(3):
        pairing.take(camera, at(0))
    pairing.take(0, at(20))
    pairing.leave_out(1)
    assert cameras(pairing.take(2, at(20))) == [(0, 2)]


def test_what_waits_in_vain_does_not_pile_up() -> None:
    """One camera is silent for an hour."""
    pairing = Simultaneous(2, 0.05, 0.0)
    for step in range(3 * MOST):
        pairing.take(0, at(step))
    assert len(pairing.take(1, at(3 * MOST))) == 0
    assert pairing.unseen == MOST

"""Bearings as they come -> sightings: complete, or ended by the interval."""

from __future__ import annotations

from blob_tracker.constellation import ConstellationError, Sighting
from blob_tracker.types import Bearing
import numpy as np
import pytest

MS = 1_000_000


def stamps(
    sighting: Sighting, come: list[tuple[str, int]]
) -> list[list[tuple[str, int]]]:
    """Return the sightings of bearings with these stamps, ms."""
    found = []
    for name, at in come:
        ended = sighting.take(name, Bearing(0.0, 0.0, np.eye(2), at * MS))
        if ended:
            found.append([(name, each.stamp_ns // MS) for name, each in ended])
    return found


def test_all_lights_make_a_sighting_at_once() -> None:
    """In the order of the body, whatever theirs is; each bearing is in one sighting."""
    assert stamps(Sighting('abc', 0.1), [
        ('b', 1), ('c', 3), ('a', 2), ('a', 12), ('b', 11), ('c', 13),
    ]) == [[('a', 2), ('b', 1), ('c', 3)], [('a', 12), ('b', 11), ('c', 13)]]


def test_a_hidden_light_is_waited_for_as_long_as_the_interval() -> None:
    """Though the others come again and again, of which the last bearings count."""
    come = [(name, at) for at in range(0, 100, 10) for name in 'ab']
    assert stamps(Sighting('abc', 0.045), come) == [[('a', 40), ('b', 40)]]
    assert stamps(Sighting('abc', 0.04), [*come[:10], ('c', 41)]) == [[('a', 40), ('b', 40)]]


def test_stamps_that_go_back_are_said() -> None:
    """An old one is left out; where they jump back it is begun afresh, as after a clock's jump."""
    sighting = Sighting('abc', 0.1)
    assert not stamps(sighting, [('a', 1000), ('b', 1000)])
    with pytest.raises(ConstellationError, match='it is left out'):
        stamps(sighting, [('a', 1000)])
    with pytest.raises(ConstellationError, match='jumped back by 0.900 s'):
        stamps(sighting, [('a', 100)])
    assert stamps(sighting, [('b', 101), ('c', 102)]) == [[('a', 100), ('b', 101), ('c', 102)]]
    assert not stamps(sighting, [('a', 500), ('b', 501)])
    sighting.forget(500 * MS)
    assert stamps(sighting, [('c', 502), ('b', 503)]) == [[('a', 500), ('b', 503), ('c', 502)]]


def test_a_light_that_is_late_is_said_and_the_others_go_on() -> None:
    """The others, whose bearings come 160 ms before its, make a sighting each interval."""
    sighting = Sighting('abcd', 0.1)
    come = sorted(
        (at + 160 * (name == 'd'), at, name) for name in 'abcd' for at in range(0, 3000, 50))
    said, found = [], []
    for arrival, at, name in come:
        if arrival >= 3000:
            break
        try:
            found += stamps(sighting, [(name, at)])
        except ConstellationError as error:
            said.append(str(error))
    assert len(said) == 57
    assert all('later than those of other lights' in each for each in said)
    assert len(found) == 19
    assert {len(each) for each in found} == {3}


def test_one_stamp_that_is_far_ahead_ends_nothing() -> None:
    """Its light may never come again: another that is late for an interval begins afresh."""
    sighting = Sighting('abc', 0.1)
    assert stamps(sighting, [('a', 1000), ('c', 99_000)]) == [[('a', 1000)]]
    for name, at, sentence in (
        ('a', 1010, 'later than those'), ('b', 1010, 'later than those'),
        ('a', 1110, 'later than those'), ('a', 1111, 'jumped back'),
    ):
        with pytest.raises(ConstellationError, match=sentence):
            stamps(sighting, [(name, at)])
    last = [('a', 1111), ('b', 1112), ('c', 1113)]
    assert stamps(sighting, last[1:]) == [last]

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

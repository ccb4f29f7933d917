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


def in_step(frames: int, missed: dict[int, str]) -> list[tuple[str, int]]:
    """Return the bearings of five lights with a stamp for each frame of 50 ms, but these."""
    return [
        (name, 50 * frame) for frame in range(frames) for name in 'abcde'
        if name not in missed.get(frame, '')
    ]


@pytest.mark.parametrize(('begun', 'missed'), [
    (0, {14: 'c', 19: 'a', 26: 'e', 33: 'bd'}),
    (3, {24: 'c'}),  # with the fourth light of a frame
])
def test_lights_in_step_are_not_mixed_with_those_of_another_frame(
    begun: int, missed: dict[int, str]
) -> None:
    """If a frame misses one, that of the next would complete it, and so on ever after."""
    found = stamps(Sighting('abcde', 0.2), in_step(40, missed)[begun:])
    known = [each for each in found if max(each, key=lambda one: one[1])[1] >= 50 * 12]
    assert {len({at for _, at in each}) for each in known} == {1}
    assert [len(each) for each in known] == [5] * (28 - len(missed))


def test_messages_that_overtake_those_of_another_topic_do_not_mix_frames() -> None:
    """Each frame that has all is a sighting, in whatever order the topics of two are read."""
    random = np.random.default_rng(3)
    come = in_step(60, {})
    for begin in range(0, len(come), 10):  # two frames are there at once, topic by topic
        of_topics = {name: [each for each in come[begin:begin + 10] if each[0] == name]
                     for name in random.permutation(list('abcde'))}
        come[begin:begin + 10] = sum(of_topics.values(), [])
    found = stamps(Sighting('abcde', 0.2), come)
    assert [{at for _, at in each} for each in found[-40:]] == [
        {50 * frame} for frame in range(20, 60)]
    assert {len(each) for each in found} == {5}


def test_a_hidden_light_in_step_leaves_the_others_of_one_frame() -> None:
    """The last frame that shows most of them, not the newest bearing of each."""
    hidden = dict.fromkeys(range(20, 26), 'e') | {24: 'be'}
    found = stamps(Sighting('abcde', 0.2), in_step(26, hidden))
    assert found[-1] == [(name, 1150) for name in 'abcd']
    assert len(found) == 21


def test_coded_lights_are_taken_as_they_come() -> None:
    """Lit for two bits of three, each by its own code: a sighting ends as the last one is seen."""
    random = np.random.default_rng(5)
    sighting, seen = Sighting('abcde', 0.5), dict[str, int]()
    found, expected = [], []
    for frame in range(400):
        for name in 'abcde':
            if random.random() < 2 / 3:
                found += stamps(sighting, [(name, 17 * frame)])
                seen[name] = 17 * frame
                if len(seen) == 5:
                    expected.append(sorted(seen.items()))
                    seen = {}
    assert found == expected and len(found) > 100

"""Bearings without names -> the lights that they are of, or silence with the reason."""

from __future__ import annotations

from blob_tracker.constellation import (
    assigned, Assignment, Body, ConstellationError, Inconsistent, TooFewLights,
)
from blob_tracker.types import Bearing
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
SIGMA = 0.1  # mrad
NAMES = ('port', 'starboard', 'left', 'right', 'mast')
PLACES = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [-0.2, -0.1, -0.05], [0.0, 0.0, 0.2],
])
BODY = Body(NAMES, PLACES, np.zeros(5))
SQUARE = np.array([[0.1, 0.1, 0.0], [-0.1, 0.1, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.1, 0.0]])
POSITION = np.array([0.2, 0.1, 2.0])


def sight(
    random: np.random.Generator, places: Array, rotation: Array, stamp_ns: int = 0,
    position: Array = POSITION,
) -> list[Bearing]:
    """Return what a camera sees of lights, in their order."""
    seen = []
    for x, y, z in places @ rotation.T + position:
        noise = random.normal(0.0, SIGMA, 2)
        seen.append(Bearing(
            1e3 * np.arctan2(x, z) + noise[0], 1e3 * np.arctan2(-y, np.hypot(x, z)) + noise[1],
            SIGMA**2 * np.eye(2), stamp_ns,
        ))
    return seen


@pytest.mark.parametrize('count', [4, 5])
def test_each_bearing_has_the_name_of_its_light(count: int) -> None:
    """In any order and turn; seldom more than one way, and then the right one is among them."""
    random = np.random.default_rng(1)
    body = Body(NAMES[:count], PLACES[:count], np.zeros(count))
    certain = 0
    for seed in range(50):
        order = random.permutation(count)
        seen = sight(random, PLACES[:count], Rotation.random(random_state=seed).as_matrix())
        ways = {each.names for each in assigned(body, [seen[light] for light in order])}
        assert tuple(NAMES[light] for light in order) in ways
        certain += len(ways) == 1
    assert certain >= 48  # 4 bearings have 24 orders of some poses each: one in 100 fits by chance


def test_a_bearing_that_is_no_light_and_a_light_that_is_hidden() -> None:
    """The one has no name, the other is not missed."""
    random = np.random.default_rng(2)
    for seed in range(20):
        seen = sight(random, PLACES, Rotation.random(random_state=seed).as_matrix())
        lamp = Bearing(250.0, 120.0, SIGMA**2 * np.eye(2))
        found = assigned(BODY, [lamp, *seen])
        assert found[0].names == ('', *NAMES)
        best = assigned(BODY, seen[1:])
        assert NAMES[1:] in {each.names for each in best}


def test_a_symmetric_body_is_silent() -> None:
    """It looks the same from four sides: all of them are returned, and none is taken."""
    random = np.random.default_rng(3)
    body = Body(NAMES[:4], SQUARE, np.zeros(4))
    turn = Rotation.from_euler('xyz', [0.4, 0.3, 0.2]).as_matrix()
    seen = sight(random, SQUARE, turn)
    assert len({each.names for each in assigned(body, seen)}) >= 4
    with pytest.raises(Inconsistent, match='the body looks the same from several sides'):
        Assignment(body, 0.5).name(seen)


def test_names_are_kept_from_one_sighting_to_the_next() -> None:
    """Also where lights are hidden; after a pause they are told anew."""
    random = np.random.default_rng(4)
    assignment = Assignment(BODY, 0.5)
    for step in range(40):
        turn = Rotation.from_rotvec([0.02 * step, 0.05 * step, 0.01 * step]).as_matrix()
        stamp_ns = step * 33_000_000 + (10**9 if step > 30 else 0)
        seen = sight(random, PLACES, turn, stamp_ns)
        order = random.permutation(5)[:4 if step % 3 == 2 else 5]
        named = assignment.name([seen[light] for light in order])
        assert dict(named) == {NAMES[light]: seen[light] for light in order}


def test_what_cannot_be_told_is_said() -> None:
    """Too few, too many, and lights of another body."""
    random = np.random.default_rng(5)
    seen = sight(random, PLACES, np.eye(3))
    with pytest.raises(TooFewLights, match='3 lights without names are seen; 4 are needed'):
        assigned(BODY, seen[:3])
    with pytest.raises(ConstellationError, match='are too many to be distinguished'):
        assigned(BODY, seen * 6)
    with pytest.raises(ConstellationError, match='a bearing is not finite'):
        assigned(BODY, [Bearing(np.nan, 0.0, np.eye(2)), *seen])
    other = sight(random, random.normal(0.0, 0.2, (5, 3)), np.eye(3))
    with pytest.raises(Inconsistent, match='no assignment of the bearings'):
        assigned(BODY, other)

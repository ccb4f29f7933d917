"""Poses followed over time: what is refuted is dropped, and one bad sighting decides nothing."""

from __future__ import annotations

from collections import Counter

from blob_tracker.constellation import (
    Body, ConstellationError, Following, Inconsistent, Pose, poses,
)
from blob_tracker.types import Bearing
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
SIGMA = 0.1  # mrad
RATE = 30.0  # sightings a second
NAMES = ('port', 'starboard', 'left', 'right', 'mast')
FLAT = np.array([[0.1, 0.1, 0.0], [-0.1, 0.12, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.09, 0.0]])
PLACES = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [-0.2, -0.1, -0.05], [0.0, 0.0, 0.2],
])
WRONG = 60.0  # of the squared error over its covariance; 5e-11 are beyond it


class Flight:
    """A body that sways and turns before a camera."""

    def __init__(self, places: Array, distance: float, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._frequencies = self._random.uniform(0.1, 0.6, (6, 3))
        self._phases = self._random.uniform(0.0, 2.0 * np.pi, (6, 3))
        self._turn = Rotation.random(random_state=seed)
        self._places, self._distance = places, distance

    def pose(self, time: float) -> tuple[Array, Array]:
        """Return turn and place at a time, s."""
        swings = np.sin(2.0 * np.pi * self._frequencies * time + self._phases).sum(axis=1)
        moved = np.repeat([0.25, 0.4], 3) * swings
        turn = Rotation.from_rotvec(moved[3:]) * self._turn
        return turn.as_matrix(), moved[:3] + np.array([0.2, 0.1, self._distance])

    def seen(
        self, time: float, step: float = 0.0, off: float = 0.0
    ) -> list[tuple[str, Bearing]]:
        """Return the bearings, each `step` s after the last, the first one off by mrad."""
        found = []
        for number, place in enumerate(self._places):
            at = time - step * (len(self._places) - 1 - number)
            rotation, position = self.pose(at)
            x, y, z = rotation @ place + position
            noise = self._random.normal(0.0, SIGMA, 2) + (off if number == 0 else 0.0)
            found.append((NAMES[number], Bearing(
                1e3 * np.arctan2(x, z) + noise[0], 1e3 * np.arctan2(-y, np.hypot(x, z)) + noise[1],
                SIGMA**2 * np.eye(2), round(1e9 * (10.0 + at)),
            )))
        return found

    def judged(self, found: list[Pose], time: float) -> str:
        """Say whether poses are one, and the right one."""
        if len(found) > 1:
            return 'several'
        rotation, position = self.pose(time)
        error = np.concatenate([
            position - found[0].position,
            Rotation.from_matrix(rotation @ found[0].rotation.T).as_rotvec(),
        ])
        squared = float(error @ np.linalg.solve(found[0].covariance, error))
        return 'right' if squared < WRONG else 'wrong'


def test_of_two_poses_one_is_refuted() -> None:
    """Four lights in a plane, 30 times as far as large: seldom told at once, mostly in time."""
    body = Body(NAMES[:4], FLAT, np.zeros(4))
    alone, followed = Counter[str](), Counter[str]()
    for seed in range(10):
        flight, following = Flight(FLAT, 6.0, 100 + seed), Following(body)
        for number in range(60):
            time = number / RATE
            seen = flight.seen(time)
            alone[flight.judged(poses(body, seen), time)] += 1
            followed[flight.judged(following.take(seen), time)] += 1
    assert followed['wrong'] == 0
    assert alone['several'] > 100
    assert followed['several'] < 0.5 * alone['several']


def test_one_of_five_lights_is_wrong_where_stamps_differ() -> None:
    """Their motion is known of the sightings before: the wrong one is named, and not used."""
    body = Body(NAMES, PLACES, np.zeros(5))
    alone, followed = Counter[str](), Counter[str]()
    for seed in range(5):
        flight, following = Flight(PLACES, 2.0, 200 + seed), Following(body)
        for number in range(60):
            time = number / RATE
            wrong = number % 6 == 5
            seen = flight.seen(time, 1e-3, 20.0 if wrong else 0.0)
            found = following.take(seen)
            if wrong:
                alone[flight.judged(poses(body, seen), time)] += 1
                followed[flight.judged(found, time)] += 1
            if wrong and len(found) == 1:
                assert found[0].outliers == ('port',)
    assert followed['wrong'] == 0
    assert followed['right'] > 0.9 * followed.total()
    assert followed['right'] > alone['right']


def test_one_bad_sighting_does_not_decide() -> None:
    """A single pose from elsewhere is not taken until it stays; nor after a pause is it waited."""
    body = Body(NAMES, PLACES, np.zeros(5))
    flight, other, following = Flight(PLACES, 2.0, 1), Flight(PLACES, 2.0, 2), Following(body)
    for number in range(10):
        assert len(following.take(flight.seen(number / RATE))) == 1
    taken = []
    for number in range(10, 30):
        try:
            taken.append(len(following.take(other.seen(number / RATE))))
        except ConstellationError:
            taken.append(0)
    assert taken[0] != 1
    assert taken[1] != 1
    assert taken[-1] == 1
    found = following.take(flight.seen(3.0))
    assert flight.judged(found, 3.0) == 'right'


@pytest.mark.parametrize('step', [0.0, 1e-3])
def test_exchanged_names_are_told(step: float) -> None:
    """Also where a body that moves meanwhile would explain four of the five."""
    body = Body(NAMES, PLACES, np.zeros(5))
    for seed in range(3):
        flight, following = Flight(PLACES, 2.0, 300 + seed), Following(body)
        for number in range(15):
            (one, first), (two, second), *others = flight.seen(number / RATE, step)
            with pytest.raises(Inconsistent, match='port and starboard are exchanged'):
                following.take([(one, second), (two, first), *others])


def test_one_light_that_is_off_from_the_start() -> None:
    """Its motion from one sighting to the next tells which one it is."""
    body = Body(NAMES, PLACES, np.zeros(5))
    counts = Counter[str]()
    for seed in range(4):
        flight, following = Flight(PLACES, 2.0, 300 + seed), Following(body)
        for number in range(20):
            time = number / RATE
            try:
                counts[flight.judged(following.take(flight.seen(time, 1e-3, 20.0)), time)] += 1
            except Inconsistent:
                counts['refused'] += 1
    assert counts['wrong'] == 0
    assert counts['right'] > 0.7 * counts.total()

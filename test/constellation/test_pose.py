"""Bearings of a body's lights -> all poses that they leave, each with its covariance."""

from __future__ import annotations

from blob_tracker.constellation import (
    Body, ConstellationError, Inconsistent, Pose, poses, TooFewLights,
)
from blob_tracker.types import Bearing
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

Array = NDArray[np.float64]
SIGMA = 0.1  # mrad
PLACES = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [-0.2, -0.1, -0.05], [0.0, 0.0, 0.2],
])
NAMES = ('port', 'starboard', 'left', 'right', 'mast')
BODY = Body(NAMES, PLACES, np.zeros(5))
SIGHTS = 300


def sight(
    random: np.random.Generator, places: Array, rotation: Array, position: Array,
    twist: Array = np.zeros(6), apart: Array = np.zeros(5),
) -> list[tuple[str, Bearing]]:
    """Return what a camera sees of lights, each so many s off the pose's instant."""
    seen = []
    for name, place, late in zip(NAMES, places, apart):
        turn = Rotation.from_rotvec(twist[3:] * late).as_matrix()
        x, y, z = turn @ rotation @ place + position + twist[:3] * late
        angles = 1e3 * np.array([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))])
        azimuth, elevation = angles + random.normal(0.0, SIGMA, 2) / [
            np.cos(1e-3 * angles[1]), 1.0]
        noise = SIGMA**2 * np.diag([1.0 / np.cos(1e-3 * angles[1])**2, 1.0])
        seen.append((name, Bearing(azimuth, elevation, noise, int(1e9 + 1e9 * late))))
    return seen


def squared(pose: Pose, rotation: Array, position: Array) -> float:
    """Return the squared error over its covariance."""
    error = np.concatenate([
        position - pose.position,
        Rotation.from_matrix(rotation @ pose.rotation.T).as_rotvec(),
    ])
    return float(error @ np.linalg.solve(pose.covariance, error))


@pytest.mark.parametrize('forward', [2.0, -1.0], ids=['ahead', 'behind'])
def test_the_pose_is_right_within_its_covariance(forward: float) -> None:
    """Also past 90 degrees from the axis, as a fish-eye sees it."""
    random = np.random.default_rng(1)
    position = np.array([1.5, 0.3, forward])
    total, certain = 0.0, 0
    for seed in range(SIGHTS):
        rotation = Rotation.random(random_state=seed).as_matrix()
        found = poses(BODY, sight(random, PLACES, rotation, position))
        if len(found) == 1:
            total += squared(found[0], rotation, position)
            certain += 1
    assert certain > 0.97 * SIGHTS
    low, high = chi2.ppf([0.001, 0.999], 6 * certain)
    assert low < total < high


def test_places_that_are_not_exact_are_in_the_covariance() -> None:
    """Each sight is of a body built anew."""
    random = np.random.default_rng(2)
    body = Body(NAMES, PLACES, np.full(5, 0.002))
    position = np.array([0.2, 0.1, 2.0])
    total = 0.0
    for seed in range(SIGHTS):
        rotation = Rotation.random(random_state=seed).as_matrix()
        built = PLACES + random.normal(0.0, 0.002, PLACES.shape)
        found = poses(body, sight(random, built, rotation, position))
        total += min(squared(each, rotation, position) for each in found)
    # The least of several where there are several: a little less than its mean.
    low, high = chi2.ppf([0.001, 0.999], 6 * SIGHTS)
    assert 0.97 * low < total < high


def test_the_twist_is_found_with_the_pose() -> None:
    """A body that turns at 3 rad/s is elsewhere at the stamp of each of its lights."""
    random = np.random.default_rng(3)
    apart = np.array([-0.04, -0.03, -0.02, -0.01, 0.0])
    position = np.array([0.2, 0.1, 2.0])
    # As much as is said beforehand: the covariance is that of bodies that move so.
    total = 0.0
    for seed in range(SIGHTS):
        rotation = Rotation.random(random_state=seed).as_matrix()
        twist = random.normal(0.0, 1.0, 6)
        found = poses(
            BODY, sight(random, PLACES, rotation, position, twist, apart),
            speed_sigma=1.0, rate_sigma=1.0,
        )
        total += min(squared(each, rotation, position) for each in found)
        assert {each.stamp_ns for each in found} == {1_000_000_000}
    # What is not straight within 40 ms at 1 rad/s is below the noise.
    low, high = chi2.ppf([0.001, 0.999], 6 * SIGHTS)
    assert 0.9 * low < total < 1.05 * high


def test_bearings_of_one_instant_say_nothing_of_the_twist() -> None:
    """It is zero, and as uncertain as is said beforehand."""
    rotation, position = Rotation.random(random_state=1).as_matrix(), np.array([0.2, 0.1, 2.0])
    found = poses(
        BODY, sight(np.random.default_rng(5), PLACES, rotation, position),
        speed_sigma=2.0, rate_sigma=0.5,
    )
    for each in found:
        np.testing.assert_array_equal(each.twist, np.zeros(6))
        np.testing.assert_array_equal(
            each.twist_covariance, np.diag([4.0, 4.0, 4.0, 0.25, 0.25, 0.25]))


def test_one_bearing_in_five_may_be_of_another_light() -> None:
    """It is named; the pose is that of the others, or is not said to be the only one."""
    random = np.random.default_rng(4)
    position = np.array([0.2, 0.1, 2.0])
    certain = []
    for seed in range(100):
        rotation = Rotation.random(random_state=seed).as_matrix()
        seen = sight(random, PLACES, rotation, position)
        name, bearing = seen[2]
        off = Bearing(bearing.azimuth + 30.0, bearing.elevation - 20.0, bearing.covariance,
                      bearing.stamp_ns)
        found = poses(BODY, [*seen[:2], (name, off), *seen[3:]])
        if len(found) == 1:
            certain.append(found[0])
            assert squared(found[0], rotation, position) < chi2.isf(1e-6, 6)
            assert found[0].outliers == ('left',)
    assert len(certain) > 85


def test_what_is_ambiguous_is_never_given_as_certain() -> None:
    """Three lights, and a square far away: more than one pose, the true one among them."""
    random = np.random.default_rng(5)
    square = np.array([[0.1, 0.1, 0.0], [-0.1, 0.1, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.1, 0.0]])
    for body, places, position in (
        (Body(NAMES[:3], PLACES[:3], np.zeros(3)), PLACES[:3], np.array([0.1, 0.0, 2.0])),
        (Body(NAMES[:4], square, np.zeros(4)), square, np.array([0.1, 0.0, 8.0])),
    ):
        several = 0
        for seed in range(50):
            rotation = Rotation.random(random_state=seed).as_matrix()
            try:
                found = poses(body, sight(random, places, rotation, position))
            except Inconsistent:
                continue
            several += len(found) > 1
            if len(found) == 1:
                assert squared(found[0], rotation, position) < 60.0
        assert several > 35


def test_what_gives_no_pose_is_named() -> None:
    """In a sentence each."""
    random = np.random.default_rng(6)
    rotation = Rotation.random(random_state=1).as_matrix()
    position = np.array([0.2, 0.1, 2.0])
    seen = sight(random, PLACES, rotation, position)
    with pytest.raises(TooFewLights, match='2 lights are seen'):
        poses(BODY, seen[:2])
    with pytest.raises(ConstellationError, match='a light has two bearings'):
        poses(BODY, [*seen, seen[0]])
    with pytest.raises(ConstellationError, match='the body has no light lamp'):
        poses(BODY, [*seen, ('lamp', seen[0][1])])
    for bearing in (
        Bearing(np.nan, 0.0, np.eye(2)), Bearing(0.0, 0.0, np.zeros((2, 2))),
    ):
        with pytest.raises(ConstellationError, match='the bearing of port or its covariance'):
            poses(BODY, [('port', bearing), *seen[1:]])
    with pytest.raises(Inconsistent, match='a mirror image of the body'):
        poses(Body(NAMES, PLACES * [1.0, -1.0, 1.0], np.zeros(5)), seen)
    others = [(name, each) for name, (_, each) in zip(NAMES, seen[2:] + seen[:2])]
    with pytest.raises(Inconsistent, match='no pose of the body explains'):
        poses(BODY, others)
    with pytest.raises(Inconsistent, match='it is too far away for its size'):
        poses(BODY, sight(random, PLACES, rotation, np.array([0.0, 0.0, 3000.0])))


def test_lights_that_are_seen_in_one_line_are_named() -> None:
    """Also where the body has others."""
    places = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0]])
    body = Body(NAMES[:4], places, np.zeros(4))
    seen = sight(np.random.default_rng(7), places, np.eye(3), np.array([0.0, 0.0, 2.0]))
    with pytest.raises(TooFewLights, match='port, starboard, left, are in one line'):
        poses(body, seen[:3])

"""Poses of one sighting after the other: of several that are likely, the one that stays so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from blob_tracker.constellation.body import Body
from blob_tracker.constellation.errors import ConstellationError, Inconsistent
from blob_tracker.constellation.pose import NS, Pose, poses
from blob_tracker.kernel import Array
from blob_tracker.types import Bearing
import numpy as np
import scipy  # which loads its parts when they are first used

REFUTED = 25.0  # of chi-square behind the best: as poses of one sighting are told apart
BOUND = 12.0  # that one sighting can add: no two of them decide
UNLIKELY = 50.0  # behind the best: such a pose is given up
MEMORY = 0.95  # of what was added is kept from one sighting to the next
GATE = 5.0  # standard deviations that a body may be off the place where it was
LONGEST_S = 0.5  # without a pose: then all start again
CHANGE_S = 0.3  # in which a body may change its twist by all that it may have


@dataclass(frozen=True)
class _Way:
    """A pose that is followed, and how much less likely than the best it is, in chi-square."""

    pose: Pose
    behind: float


class Following:
    """
    Follow the poses that bearings leave, until one is left.

    What a sighting says of each, its cost over that of the best, is added up. One sighting adds
    12 at most, so that a bad one does not decide, and what was added fades, so that an error that
    all sightings share (places in the body file) does not either: a pose is refuted once it is 25
    behind. It is that of the one before where the body can have come from there; one that appears
    from elsewhere begins refuted. Once a single pose is left, its motion tells the twist that the
    next bearings are expected to have: stamps that differ need not tell it by themselves.

    Parameters
    ----------
    body : Body
        Its lights.

    Examples
    --------
    Four lights nearly in a plane have two poses from afar, of which one is left as they come near:

    >>> places = np.array([[0.1, 0.1, 0], [-0.1, 0.12, 0.01], [-0.1, -0.1, 0], [0.1, -0.09, 0]])
    >>> body = Body(('a', 'b', 'c', 'd'), places, np.zeros(4))
    >>> following, left = Following(body), []
    >>> for index in range(20):
    ...     x, y, z = (places + [0.2, 0.1, 2.3 - 0.02 * index]).T
    ...     azimuths, elevations = 1e3 * np.arctan2(x, z), 1e3 * np.arctan2(-y, np.hypot(x, z))
    ...     left.append(len(following.take([
    ...         (name, Bearing(*angles, 0.02 * np.eye(2), 33_333_333 * index))
    ...         for name, *angles in zip(body.names, azimuths, elevations)
    ...     ])))
    >>> left[0], left[-1]  # poses
    (2, 1)

    """

    def __init__(self, body: Body) -> None:
        self._body = body
        self._ways: list[_Way] = []
        self._twist: tuple[Array, float, float] | None = None  # with the deviations of both parts

    def take(
        self, bearings: Sequence[tuple[str, Bearing]], *, speed_sigma: float = 3.0,
        rate_sigma: float = 3.0, gate_sigma: float = 5.0,
    ) -> list[Pose]:
        """
        Take the bearings of a sighting; return the poses that are left, the likeliest first.

        Parameters
        ----------
        bearings, speed_sigma, rate_sigma, gate_sigma
            As `poses` has them.

        Raises
        ------
        ConstellationError
            As `poses` does.
        Inconsistent
            Also where they have poses, but not the one that is followed.

        """
        latest = max((each.stamp_ns for _, each in bearings), default=0)
        after = [NS * (latest - way.pose.stamp_ns) for way in self._ways]
        if not after or min(after) > LONGEST_S or min(after) <= 0.0:
            self.forget()
        loose: dict[str, Any] = {
            'speed_sigma': speed_sigma, 'rate_sigma': rate_sigma, 'gate_sigma': gate_sigma,
        }
        found = self._found(bearings, loose)
        before = self._ways
        self._ways = self._followed(found, before, speed_sigma, rate_sigma)
        left = [way.pose for way in self._ways if way.behind < REFUTED]
        if len(left) == 1 and not any(left[0] is pose for pose in found):
            raise Inconsistent(
                f'{len(found)} poses explain the bearings, but not the one that was followed; if '
                'it stays so, another is taken'
            )
        self._twist = None
        if len(left) == 1:
            parents = [
                way.pose for way in before
                if _is_near(left[0], way.pose, speed_sigma, rate_sigma)
            ]
            if len(parents) == 1:
                self._twist = _twist(parents[0], left[0], speed_sigma, rate_sigma)
        return left

    def forget(self) -> None:
        """Begin anew."""
        self._ways, self._twist = [], None

    def _found(
        self, bearings: Sequence[tuple[str, Bearing]], loose: dict[str, Any]
    ) -> list[Pose]:
        """Return the poses of a sighting, with the twist that is expected where one is."""
        if self._twist is not None:
            twist, speed_sigma, rate_sigma = self._twist
            try:
                return poses(
                    self._body, bearings, twist=twist, speed_sigma=speed_sigma,
                    rate_sigma=rate_sigma, gate_sigma=loose['gate_sigma'],
                )
            except ConstellationError:
                pass  # it moves otherwise now
        return poses(self._body, bearings, **loose)

    def _followed(
        self, found: Sequence[Pose], before: Sequence[_Way], speed_sigma: float,
        rate_sigma: float,
    ) -> list[_Way]:
        """Return all poses that are followed from now on, the likeliest first."""
        least = found[0].cost
        ways, goes_on = [], [False] * len(before)
        for pose in found:
            added = min(pose.cost - least, BOUND)
            parents = [
                number for number, way in enumerate(before)
                if _is_near(pose, way.pose, speed_sigma, rate_sigma)
            ]
            for number in parents:
                goes_on[number] = True
            start = min(
                (before[number].behind for number in parents),
                default=REFUTED if before else 0.0,
            )
            ways.append(_Way(pose, MEMORY * start + added if parents else start + added))
        for way, one in zip(before, goes_on, strict=True):
            if not one:
                ways.append(replace(way, behind=MEMORY * way.behind + BOUND))
        best = min(way.behind for way in ways)
        ways = [replace(way, behind=way.behind - best) for way in ways]
        return sorted(
            (way for way in ways if way.behind < UNLIKELY), key=lambda way: way.behind
        )


def _is_near(pose: Pose, before: Pose, speed_sigma: float, rate_sigma: float) -> bool:
    """Tell whether a body can have come to a pose from one before."""
    after = NS * (pose.stamp_ns - before.stamp_ns)
    error = pose.covariance + before.covariance
    error[:3, :3] += (speed_sigma * after)**2 * np.eye(3)
    error[3:, 3:] += (rate_sigma * after)**2 * np.eye(3)
    turned = _turned(pose, before)
    way = np.concatenate([pose.position - before.position, turned])
    return bool(way @ np.linalg.solve(error, way) < GATE**2 + 6.0)


def _twist(
    before: Pose, pose: Pose, speed_sigma: float, rate_sigma: float
) -> tuple[Array, float, float] | None:
    """Return the twist from one pose to the next, with the deviations of the one after it."""
    after = NS * (pose.stamp_ns - before.stamp_ns)
    turned = _turned(pose, before)
    twist = np.concatenate([pose.position - before.position, turned]) / after
    error = np.sqrt((before.covariance + pose.covariance).diagonal()) / after
    changed = 1.5 * after / CHANGE_S  # from amid the two to the next
    sigmas = [
        float(np.hypot(sigma * changed, part.max()))
        for sigma, part in ((speed_sigma, error[:3]), (rate_sigma, error[3:]))
    ]
    if sigmas[0] >= speed_sigma or sigmas[1] >= rate_sigma:
        return None  # it is known no better than before
    return np.asarray(twist), sigmas[0], sigmas[1]


def _turned(pose: Pose, before: Pose) -> Array:
    """Return the turn from one pose to the other, rad."""
    turn = scipy.spatial.transform.Rotation.from_matrix(pose.rotation @ before.rotation.T)
    return np.asarray(turn.as_rotvec())

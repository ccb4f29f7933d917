"""Poses of one sighting after the other: of several that are likely, the one that stays so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
import math
from typing import NamedTuple

from blob_tracker.constellation.body import Body
from blob_tracker.constellation.errors import Inconsistent
from blob_tracker.constellation.pose import NS, Pose, pose_near, poses, STILL
from blob_tracker.kernel import Array
from blob_tracker.types import Bearing
import numpy as np

REFUTED = 25.0  # of chi-square behind the best: as poses of one sighting are told apart
BOUND = 12.0  # that one sighting can add: no two of them decide
UNLIKELY = 50.0  # behind the best: such a pose is given up
MEMORY = 0.95  # of what was added is kept from one sighting to the next
SAME2 = 4.0  # by what is expected of its motion a pose differs by less than it is known
NEAR2 = 31.0  # six squared deviates, 2e-5 are beyond it: a pose is where another may have led
LONGEST_S = 0.5  # without a pose: then all start again
SUSPECT = 0.05  # so improbable a chi-square may be of other lights, taken for motion
CHANGE_S = 0.3  # in which a body may change its twist by all that it may have


class _Motion(NamedTuple):
    """A twist, m/s and rad/s, and the deviations of its two parts."""

    twist: Array
    speed_sigma: float
    rate_sigma: float


@dataclass(frozen=True)
class _Way:
    """
    A pose that is followed.

    Parameters
    ----------
    pose : Pose
        Of the last sighting that had it.
    behind : float
        How much less likely than the best it is, in chi-square.
    motion : _Motion, optional
        What the way to it tells of the next.
    is_sure : bool
        Whether no wrong pose would pass for it: see `_is_sure`.

    """

    pose: Pose
    behind: float
    motion: _Motion | None = None
    is_sure: bool = True


class Following:
    """
    Follow the poses that bearings leave, until one is left.

    What a sighting says of each, its cost over that of the best, is added up. One sighting adds
    12 at most, so that a bad one does not decide, and what was added fades, so that an error that
    all sightings share (places in the body file) does not either: a pose is refuted once it is 25
    behind. It is that of the one before where the body can have come from there; one that appears
    from elsewhere begins refuted.

    Within a sighting whose stamps differ a body may move, and bearings of other lights may be
    taken for motion. So each pose is expected to move on as it came, and one whose bearings say
    otherwise is not certain.

    Parameters
    ----------
    body : Body
        Its lights.

    Examples
    --------
    Four lights nearly in a plane have two poses from afar, and one when they have come near:

    >>> places = np.array([[0.1, 0.1, 0], [-0.1, 0.12, 0.01], [-0.1, -0.1, 0], [0.1, -0.09, 0]])
    >>> body = Body(('a', 'b', 'c', 'd'), places, np.zeros(4))
    >>> following, left = Following(body), []
    >>> for index in range(50):
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
            Also where they have poses, but not the one that is followed, or it does not move as
            they say.

        """
        latest = max((each.stamp_ns for _, each in bearings), default=0)
        after = [NS * (latest - way.pose.stamp_ns) for way in self._ways]
        if not after or min(after) > LONGEST_S or min(after) <= 0.0:
            self.forget()
        known = _Motion(STILL, speed_sigma, rate_sigma)
        found = poses(
            self._body, bearings, speed_sigma=speed_sigma, rate_sigma=rate_sigma,
            gate_sigma=gate_sigma,
        )
        moves = len({each.stamp_ns for _, each in bearings}) > 1
        expected = [
            self._expected(way, bearings, latest, gate_sigma) if moves else []
            for way in self._ways
        ]
        self._ways = _followed(found, self._ways, expected, known, moves)
        left = [way for way in self._ways if way.behind < REFUTED]
        if len(left) == 1 and left[0].pose.stamp_ns != latest:
            raise Inconsistent(
                f'{len(found)} poses explain the bearings, but not the one that was followed; if '
                'it stays so, another is taken'
            )
        if len(left) == 1 and not left[0].is_sure:
            raise Inconsistent(
                'the bearings fit a pose only if the body moves otherwise than from one pose to '
                'the next, or one of them is of another light; if it stays so, lights have the '
                'names of others, or their positions in the body file are wrong'
            )
        return [way.pose for way in left]

    def forget(self) -> None:
        """Begin anew."""
        self._ways = []

    def _expected(
        self, way: _Way, bearings: Sequence[tuple[str, Bearing]], latest: int, gate_sigma: float
    ) -> list[Pose]:
        """Return the poses of a sighting if it moves on as it came: its own, and likelier ones."""
        if way.motion is None:
            return []
        import scipy  # no part of a start

        after = NS * (latest - way.pose.stamp_ns)
        turn = scipy.spatial.transform.Rotation.from_rotvec(after * way.motion.twist[3:])
        near = partial(
            pose_near, self._body, rotation=turn.as_matrix() @ way.pose.rotation,
            position=way.pose.position + after * way.motion.twist[:3], twist=way.motion.twist,
            speed_sigma=way.motion.speed_sigma, rate_sigma=way.motion.rate_sigma,
            gate_sigma=gate_sigma,
        )
        pose = near(bearings, odd=True)
        if pose is None or len(pose.outliers) != 1:
            return [] if pose is None else [pose]
        found = [pose]  # and where another one is odd
        for name, _ in bearings:
            if name not in pose.outliers:
                other = near([each for each in bearings if each[0] != name])
                if other is not None and other.stamp_ns == latest:
                    found.append(replace(other, outliers=(name,)))
        own = [each.cost for each in found if each.outliers == way.pose.outliers]
        return [each for each in found if each.cost <= min(own or [math.inf])]


def _followed(
    found: Sequence[Pose], before: Sequence[_Way], expected: Sequence[Sequence[Pose]],
    known: _Motion, moves: bool,
) -> list[_Way]:
    """Return all poses that are followed from now on, the likeliest first."""
    least = min(each.cost for each in (*found, *chain(*expected)))
    ways: list[_Way] = []
    goes_on = [len(each) > 0 for each in expected]
    for way, led in zip(before, expected, strict=True):
        for pose in led:
            if not any(_is_same(pose, each.pose, known) for each in ways):
                ways.append(_Way(
                    pose, MEMORY * way.behind + min(pose.cost - least, BOUND),
                    _motion(way.pose, pose, known),
                ))
    led_ways = list(ways)
    for pose in found:
        if any(_is_same(pose, way.pose, known) for way in led_ways):
            continue
        apart = [_apart(pose, way.pose, known) for way in before]
        parents = [number for number, one in enumerate(apart) if one < NEAR2]
        if any(expected[number] for number in parents):
            continue  # that goes on as it came
        for number in parents:
            goes_on[number] = True
        start = min(
            (MEMORY * before[number].behind for number in parents),
            default=REFUTED if before else 0.0,
        )
        ways.append(_Way(
            pose, start + min(pose.cost - least, BOUND),
            _motion(before[int(np.argmin(apart))].pose, pose, known) if parents else None,
            not moves or _is_sure(pose, [before[number] for number in parents]),
        ))
    for way, one in zip(before, goes_on, strict=True):
        if not one:
            ways.append(replace(way, behind=MEMORY * way.behind + BOUND))
    best = min(way.behind for way in ways)
    ways = [replace(way, behind=way.behind - best) for way in ways]
    return sorted((way for way in ways if way.behind < UNLIKELY), key=lambda way: way.behind)


def _is_sure(pose: Pose, parents: Sequence[_Way]) -> bool:
    """
    Tell whether a pose is certain although nothing tells how the body moved.

    Only if all bearings fit well: what the body may do meanwhile makes other lights fit, too. One
    that was expected to move otherwise is not.
    """
    import scipy

    return (
        not pose.outliers and all(way.motion is None for way in parents)
        and pose.chi2 <= scipy.special.chdtri(pose.degrees_of_freedom, SUSPECT)
    )


def _is_same(pose: Pose, other: Pose, known: _Motion) -> bool:
    """Tell whether two poses of a sighting are one, by other expectations of its motion."""
    return pose.outliers == other.outliers and _apart(pose, other, known) < SAME2


def _apart(pose: Pose, before: Pose, known: _Motion) -> float:
    """Return how far a pose is from one before, squared, over what it may be."""
    after = NS * (pose.stamp_ns - before.stamp_ns)
    error = pose.covariance + before.covariance
    error[:3, :3] += (known.speed_sigma * after)**2 * np.eye(3)
    error[3:, 3:] += (known.rate_sigma * after)**2 * np.eye(3)
    turned = _turned(pose, before)
    way = np.concatenate([pose.position - before.position, turned])
    return float(way @ np.linalg.solve(error, way))


def _motion(before: Pose, pose: Pose, known: _Motion) -> _Motion | None:
    """Return the twist from one pose to the next, with the deviations of the one after it."""
    after = NS * (pose.stamp_ns - before.stamp_ns)
    turned = _turned(pose, before)
    twist = np.concatenate([pose.position - before.position, turned]) / after
    error = np.sqrt((before.covariance + pose.covariance).diagonal()) / after
    changed = 1.5 * after / CHANGE_S  # from amid the two to the next
    speed_sigma = float(np.hypot(known.speed_sigma * changed, error[:3].max()))
    rate_sigma = float(np.hypot(known.rate_sigma * changed, error[3:].max()))
    if speed_sigma >= known.speed_sigma or rate_sigma >= known.rate_sigma:
        return None  # it is known no better than before
    return _Motion(np.asarray(twist), speed_sigma, rate_sigma)


def _turned(pose: Pose, before: Pose) -> Array:
    """Return the turn from one pose to the other, rad."""
    import scipy

    turn = scipy.spatial.transform.Rotation.from_matrix(pose.rotation @ before.rotation.T)
    return np.asarray(turn.as_rotvec())

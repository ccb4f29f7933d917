"""What a tracker says of a body's pose, beside the truth."""

from __future__ import annotations

from collections import deque
import time
from typing import NamedTuple

from blob_tracker.commands.watched_light import LONGEST, RECENT
from blob_tracker.ros.messages.stamp import to_ns
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

Array = NDArray[np.float64]

FEWEST = 10  # truths that splines need
LONGEST_GAP_NS = 100_000_000  # ns between two truths: across more the true pose is not known


class BodyScore(NamedTuple):
    """
    How poses compare with the truth.

    Parameters
    ----------
    times : (n,) array
        Since the first, s.
    positions, true : (n, 3) arrays
        Where the body was said to be, and was, m.
    turns, true_turns : Rotation
        How it was said to be turned, and was.
    errors : (n, 6) array
        m and rad.
    covariances : (n, 6, 6) array
        Of them.

    """

    times: Array
    positions: Array
    true: Array
    turns: Rotation
    true_turns: Rotation
    errors: Array
    covariances: Array

    @property
    def scatter(self) -> float:
        """Root of the mean normalised error squared of all a degree of freedom: 1 is right."""
        solved = np.linalg.solve(self.covariances, self.errors[:, :, None])[:, :, 0]
        return float(np.sqrt((self.errors * solved).sum(axis=1).mean() / 6.0))

    @property
    def rms(self) -> tuple[float, float]:
        """Error of the place, m, and of the turn, rad, each as the length of a vector."""
        place, turn = ((self.errors[:, at:at + 3] ** 2).sum(axis=1).mean() for at in (0, 3))
        return float(np.sqrt(place)), float(np.sqrt(turn))


class WatchedBody:
    """
    Poses and truths of a body, by their stamps, ns.

    Parameters
    ----------
    name : str
        Of the body.

    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.arrivals: deque[float] = deque(maxlen=RECENT)
        self._poses: dict[int, tuple[Array, Array, Array]] = {}
        self._truths: dict[int, tuple[Array, Array]] = {}

    def take(self, message: PoseWithCovarianceStamped) -> None:
        """Take a pose."""
        self.arrivals.append(time.monotonic())
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        self._poses[to_ns(message.header.stamp)] = *_numbers(message.pose.pose), covariance
        if len(self._poses) > LONGEST:
            del self._poses[next(iter(self._poses))]

    def take_truth(self, message: PoseStamped) -> None:
        """Take a true pose."""
        self._truths[to_ns(message.header.stamp)] = _numbers(message.pose)
        if len(self._truths) > LONGEST:
            del self._truths[next(iter(self._truths))]

    def score(self) -> BodyScore | None:
        """Hold the poses against the truth at their instants; None if there are none."""
        knots = sorted(self._truths)
        if len(knots) < FEWEST:
            return None
        after = np.searchsorted(knots, sorted(self._poses))
        stamps = [
            stamp for stamp, later in zip(sorted(self._poses), after.tolist())
            if 0 < later < len(knots) and knots[later] - knots[later - 1] < LONGEST_GAP_NS
        ]
        if not stamps:
            return None
        at, since = (
            1e-9 * (np.array(each, dtype=np.int64) - knots[0]) for each in (stamps, knots)
        )
        places, turns = zip(*(self._truths[knot] for knot in knots))
        true = CubicSpline(since, np.array(places))(at)
        true_turns = RotationSpline(since, Rotation.from_quat(np.array(turns)))(at)
        positions = np.array([self._poses[stamp][0] for stamp in stamps])
        found = Rotation.from_quat(np.array([self._poses[stamp][1] for stamp in stamps]))
        errors = np.concatenate(
            [true - positions, (true_turns * found.inv()).as_rotvec()], axis=1
        )
        covariances = np.array([self._poses[stamp][2] for stamp in stamps])
        return BodyScore(at - at[0], positions, true, found, true_turns, errors, covariances)


def _numbers(pose: Pose) -> tuple[Array, Array]:
    """Return place, m, and quaternion x, y, z, w."""
    place, turn = pose.position, pose.orientation
    return np.array([place.x, place.y, place.z]), np.array([turn.x, turn.y, turn.z, turn.w])

"""What a tracker says of one light, beside the truth where there is one."""

from __future__ import annotations

from collections import deque
from typing import Any

from blob_tracker.ros.messages.stamp import to_ns
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

LONGEST = 20_000  # frames that are remembered: ten minutes
RECENT = 60  # bearings over which rates and latencies are taken
FEWEST = 4  # truths that a spline needs
BUDGET = 0.05  # px rms: what the thesis wanted (section 2.1)


class Score:
    """
    How locations compare with the truth.

    Parameters
    ----------
    located : (N, 2) array
        x, y, px.
    errors : (N, 2) array
        Located less true, px.
    covariances : (N, 2, 2) array
        px^2.

    Attributes
    ----------
    sure : (N,) bool array
        Which of them claim a standard deviation a coordinate within the budget.
    rms : float
        Error of these a coordinate, px.
    scatter : float
        Root of the mean normalised error squared of all a degree of freedom: 1 is right.

    """

    def __init__(
        self,
        located: NDArray[np.float64],
        errors: NDArray[np.float64],
        covariances: NDArray[np.float64],
    ) -> None:
        self.located, self.errors, self.covariances = located, errors, covariances
        variances = 0.5 * np.trace(covariances, axis1=1, axis2=2)
        self.sure = variances <= BUDGET**2
        self.rms = float(np.sqrt(np.mean(errors[self.sure] ** 2))) if self.sure.any() else np.inf
        squared = np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariances), errors)
        self.scatter = float(np.sqrt(0.5 * squared.mean()))

    @property
    def words(self) -> str:
        """Return the figures in words."""
        count, sure = len(self.errors), int(self.sure.sum())
        of_these = '' if sure == count else f', {sure} of them with a sigma of {BUDGET} px or less'
        return (
            f'{count} bearings{of_these}, {self.rms:.4f} px rms a coordinate, scatter / sigma '
            f'{self.scatter:.2f}'
        )


class WatchedLight:
    """
    Bearings, locations and truths of a light, by their stamps, ns.

    Attributes
    ----------
    latencies, arrivals : deque of float
        Of the bearings: from the stamp to the arrival, and the time of that, s.
    bearing, ray : message or None
        The last ones.
    centroids, truths : dict of int to (float, float)
        x, y, px.
    covariances : dict of int to (2, 2) array
        Of azimuth and elevation, rad^2.

    """

    def __init__(self) -> None:
        self.latencies: deque[float] = deque(maxlen=LONGEST)
        self.arrivals: deque[float] = deque(maxlen=RECENT)
        self.bearing: Vector3Stamped | None = None
        self.ray: PoseWithCovarianceStamped | None = None
        self.centroids: dict[int, tuple[float, float]] = {}
        self.covariances: dict[int, NDArray[np.float64]] = {}
        self.truths: dict[int, tuple[float, float]] = {}

    def forget(self) -> None:
        """Restart: know nothing of what came before."""
        self.latencies.clear()
        self.arrivals.clear()
        for kept in (self.centroids, self.covariances, self.truths):
            kept.clear()

    def matched_stamps(self, interval_ns: int) -> list[int]:
        """Return the stamps of the locations that have a truth in their frame, in their order."""
        stamps = np.array(sorted(self.centroids), dtype=np.int64)
        return stamps[self._from_truth(stamps) <= 0.5 * interval_ns].tolist()

    def false_stamps(self, interval_ns: int) -> list[int]:
        """Return the stamps of locations in frames in which the light was not on."""
        if not self.truths:
            return []
        # Before the first truth and after the last it may still be under way.
        first, last = min(self.truths), max(self.truths)
        stamps = np.array([each for each in self.centroids if first < each < last], np.int64)
        return stamps[self._from_truth(stamps) > 0.5 * interval_ns].tolist()

    def matched(self, interval_ns: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """
        Return the (N, 2) locations that have a truth, and where the light was at their stamps, px.

        A light that was switched within an exposure is seen at an instant that the tracker has to
        find: the truth is taken at that of the location, from the spline through the instants at
        which the light was seen.
        """
        stamps = self.matched_stamps(interval_ns)
        located = np.array([self.centroids[stamp] for stamp in stamps]).reshape(-1, 2)
        if all(stamp in self.truths for stamp in stamps) or len(self.truths) < FEWEST:
            true = [self.truths.get(stamp, (np.nan, np.nan)) for stamp in stamps]
            return located, np.array(true).reshape(-1, 2)
        knots = sorted(self.truths)
        path = CubicSpline(_seconds(knots, knots[0]), [self.truths[knot] for knot in knots])
        return located, np.asarray(path(_seconds(stamps, knots[0])), dtype=float)

    def keep(self, store: dict[int, Any], message: Any, value: Any) -> None:
        """Store a value by its stamp; a demo on a real camera may run for days."""
        store[to_ns(message.header.stamp)] = value
        if len(store) > LONGEST:
            del store[next(iter(store))]

    def _from_truth(self, stamps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return how far from each stamp the nearest one of a truth is, ns."""
        if not self.truths:
            return np.full(len(stamps), np.iinfo(np.int64).max)
        knots = np.array(sorted(self.truths), dtype=np.int64)
        after = np.searchsorted(knots, stamps)
        before = np.abs(stamps - knots[np.maximum(after - 1, 0)])
        behind = np.abs(stamps - knots[np.minimum(after, len(knots) - 1)])
        return np.asarray(np.minimum(before, behind), dtype=np.int64)


def _seconds(stamps: list[int], first: int) -> NDArray[np.float64]:
    """Return stamps in s from the first one, to the ns."""
    return np.asarray(1e-9 * (np.array(stamps, dtype=np.int64) - first))

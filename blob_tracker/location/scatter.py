"""Whether the places of a moving target scatter as much as their covariances say."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
import math

from blob_tracker.types import Location
import numpy as np
from numpy.typing import NDArray

# Of the differences. The demo's light, which crosses a frame of 640 px in 2.2 s, moves the third
# ones at 30 Hz by as much as their noise of 0.02 px, the fourth by a twentieth of it. Higher ones
# are worth fewer degrees of freedom and feel slow drifts over the pixels less.
ORDER = 4
# Usual intervals between two neighbours: one place may be missing, not more
LONGEST_INTERVAL = 2.5
# Times the median of the differences: noise is there once in 3e7, another target or a glint is.
FARTHEST = 25.0
LEAST_DIFFERENCES = 12  # differences of which anything can be said
SIGNIFICANT_SIGMA = 3.0  # by which a ratio must lie above another to be said to


@dataclass(frozen=True)
class Scatter:
    """
    Scatter of places over the one that their covariances predict.

    Parameters
    ----------
    ratio : float
        1 where the covariances are true.
    freedom : float
        Effective degrees of freedom of its square.
    jumps : int
        Differences that are no noise and were left out.
    by_stamps : float
        The ratio if the stamps are true; it is larger than `ratio` only if they are not.

    Examples
    --------
    A ratio of 1.4 from 200 degrees of freedom, and its standard error:

    >>> scatter = Scatter(ratio=1.4, freedom=200.0, jumps=0, by_stamps=1.4)
    >>> round(scatter.error, 2), scatter.exceeds(1.0), scatter.exceeds(1.3)
    (0.07, True, False)

    """

    ratio: float
    freedom: float
    jumps: int
    by_stamps: float

    @property
    def error(self) -> float:
        """Return the standard error of the ratio: ratio / sqrt(2 freedom)."""
        return self.ratio / math.sqrt(2.0 * self.freedom)

    def exceeds(self, limit: float) -> bool:
        """Tell whether the ratio lies three standard errors above a limit."""
        return self.ratio > limit * (1.0 + SIGNIFICANT_SIGMA / math.sqrt(2.0 * self.freedom))


class RecentPlaces:
    """
    The last places of a target, in a ring that does not grow.

    Parameters
    ----------
    count : int
        Places that are kept.

    Examples
    --------
    Places that scatter as their covariances say:

    >>> places = RecentPlaces(60)
    >>> random = np.random.default_rng(1)
    >>> for index in range(60):
    ...     x, y = 300.0 + 0.01 * random.standard_normal(2)
    ...     places.add(Location(
    ...         x, y, 1e-4 * np.eye(2), 150.0, 40.0, 2.0, 50.0, 1.0, 0, stamp_ns=16_666_667 * index
    ...     ))
    >>> round(places.scatter().ratio, 1)
    1.0

    """

    def __init__(self, count: int) -> None:
        # What is asked once a second is worked out then, not with each place.
        self._places: deque[Location] = deque(maxlen=count)

    def add(self, location: Location) -> None:
        """Take the next place."""
        self._places.append(location)

    @property
    def last(self) -> Location | None:
        """Return the last of them."""
        return self._places[-1] if self._places else None

    @property
    def chi2(self) -> float:
        """Mean chi-square of their fits per degree of freedom; NaN if there is none."""
        chi2 = [each.chi2 for each in self._places]
        return float(np.mean(chi2)) if chi2 else math.nan

    def scatter(self) -> Scatter | None:
        """Return the scatter of the places, as `scatter` does."""
        return scatter(
            np.array([each.stamp_ns for each in self._places], dtype=np.int64),
            np.array([(each.x, each.y) for each in self._places]).reshape(-1, 2),
            np.array([each.covariance for each in self._places]).reshape(-1, 2, 2),
        )


def scatter(
    stamps_ns: NDArray[np.int64],
    places: NDArray[np.float64],
    covariances: NDArray[np.float64],
) -> Scatter | None:
    """
    Compare the scatter of consecutive places with their covariances, whatever the smooth motion.

    The variate difference method (Anderson, Biometrika 10 (1914); Tintner, The Variate Difference
    Method (1940)) with divided differences, so that stamps may be irregular. Of p + 1 = 5
    neighbours at the times t_k, with the weights of the divided difference of order p,

        w_k = 1 / prod_{l != k} (t_k - t_l),   d = sum_k w_k x_k,   S = sum_k w_k^2 C_k

    d is free of any motion that is a polynomial of degree p - 1 and has the covariance S: for
    equal intervals x_0 - 4 x_1 + 6 x_2 - 4 x_3 + x_4 with 70 sigma^2. Then

        ratio^2 = mean_i q_i,   q_i = d_i' S_i^-1 d_i / 2

    Neighbouring differences share places. With S_ij = sum_k w_ik w_jk C_k the variance of the
    mean of M of them is

        var = 1 / M^2 sum_ij tr(S_i^-1 S_ij S_j^-1 S_ij') / 2

    (Isserlis), and its effective degrees of freedom are 2 / var: for equal intervals
    2 M / 2.63 (as sum_j C(2p, p + j)^2 = C(4p, 2p), and C(16, 8) / C(8, 4)^2 = 2.63).

    Stamps that jitter make a fast target scatter, by its speed: where the ratio is significantly
    smaller with even intervals, between neighbours of which none is missing, that one is told.

    It sees what changes from one place to the next. An error that stays, or drifts slowly over the
    pixels, it does not see; a motion that is not smooth over 5 places, such as vibration, it does.

    Parameters
    ----------
    stamps_ns : (N,) int array
        ns, the earliest first. Differences across a gap of more than 2.5 usual intervals, or a
        stamp that is not later than the last, are left out.
    places : (N, 2) array
        x and y, px (or any two angles).
    covariances : (N, 2, 2) array
        Of each place, px^2.

    Returns
    -------
    Scatter or None
        None if fewer than 12 differences are left.

    Examples
    --------
    Places of a still light that scatter twice as far as their covariances say:

    >>> random = np.random.default_rng(1)
    >>> stamps_ns = 16_666_667 * np.arange(400)
    >>> places = 300.0 + 0.02 * random.standard_normal((400, 2))
    >>> found = scatter(stamps_ns, places, np.tile(0.01**2 * np.eye(2), (400, 1, 1)))
    >>> round(found.ratio, 1), found.exceeds(1.5)
    (2.0, True)

    """
    intervals = np.diff(stamps_ns)
    later = intervals > 0
    if len(stamps_ns) < ORDER + LEAST_DIFFERENCES or not later.any():
        return None
    usual = float(np.median(intervals[later]))
    stamped = intervals / usual
    steady = later & (stamped <= LONGEST_INTERVAL)
    by_stamps = _scatter(stamped, steady, places, covariances)
    by_count = _scatter(np.ones(stamped.size), stamped.round() == 1.0, places, covariances)
    if by_stamps is None or by_count is None or not by_stamps.exceeds(by_count.ratio):
        return by_stamps
    return replace(by_count, by_stamps=by_stamps.ratio)


def _scatter(
    intervals: NDArray[np.float64],
    steady: NDArray[np.bool_],
    places: NDArray[np.float64],
    covariances: NDArray[np.float64],
) -> Scatter | None:
    """Return the scatter of places with these intervals, in usual ones, where they are steady."""
    begins = np.flatnonzero(np.lib.stride_tricks.sliding_window_view(steady, ORDER).all(axis=1))
    if len(begins) < LEAST_DIFFERENCES:
        return None
    rows = begins[:, None] + np.arange(ORDER + 1)
    times = np.cumsum(intervals[rows[:, :-1]], axis=1)
    times = np.concatenate([np.zeros((len(rows), 1)), times], axis=1)
    apart = times[:, :, None] - times[:, None, :] + np.eye(ORDER + 1)
    weights = 1.0 / apart.prod(axis=2)
    differences = np.einsum('ik,ikp->ip', weights, places[rows])
    inverse = np.linalg.inv(np.einsum('ik,ikpq->ipq', weights**2, covariances[rows]))
    squares = 0.5 * np.einsum('ip,ipq,iq->i', differences, inverse, differences)
    kept = squares <= FARTHEST * np.median(squares)
    total = float(kept.sum())
    variance = total
    for lag in range(1, ORDER + 1):
        # The differences that begin `lag` places later, where neither was left out.
        first = np.flatnonzero(kept & np.isin(begins + lag, begins[kept]))
        second = np.searchsorted(begins, begins[first] + lag)
        shared = np.einsum(
            'ik,ikpq->ipq',
            weights[first, lag:] * weights[second, :-lag],
            covariances[rows[first, lag:]],
        )
        product = inverse[first] @ shared @ inverse[second] @ shared.transpose(0, 2, 1)
        variance += float(np.trace(product, axis1=1, axis2=2).sum())  # of both ij and ji
    ratio = math.sqrt(float(squares[kept].sum()) / total)
    return Scatter(
        ratio=ratio, freedom=2.0 * total**2 / variance, jumps=int(len(rows) - total),
        by_stamps=ratio,
    )

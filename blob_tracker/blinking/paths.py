"""Points of each frame -> paths: what is one light, whatever its pattern, through dark frames."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.blinking.motion import begin, correct, predict, project, STATE
from blob_tracker.blinking.tracks import FLUX, FLUX_SIGMA, X, XX, XY, Y, YY
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

MOST_PATHS = 192  # at a time
GATE = 18.4  # chi-square of two degrees of freedom that one in 10,000 exceeds
FIRST_SPEED = 3.0  # px a frame interval, along each axis, of a path of one point
SETTLED = 4  # points, from which on a path has the first choice
HEAD_START = 30.0  # of such a path, in units of chi-square
WIDEST = 60.0  # px, standard deviation: who may be anywhere is nobody
LONGEST_DARK_S = 1.0
BENT = 0.15  # of the way in a frame interval: a light partly lit is off the middle of its way
NONE = -1


class Path(NamedTuple):
    """
    One light through the frames.

    Parameters
    ----------
    frames : (n,) int array
        In which it was seen, counted from the first frame.
    x, y : (n,) arrays
        Where, px.
    flux, sigma : (n,) arrays
        Its light and the standard deviation of it, DN px^2.
    points : (n,) int array
        Which of the frame's points it was.

    """

    frames: NDArray[np.int64]
    x: Array
    y: Array
    flux: Array
    sigma: Array
    points: NDArray[np.int64]


class PathLinker:
    """
    Link the points of each frame to paths, with Singer's model of the motion.

    Each path takes the point that is the likeliest in its reach, those of several points first.
    No more than `MOST_PATHS` are kept at a time.

    Parameters
    ----------
    interval : float
        From frame to frame, s.

    """

    def __init__(self, interval: float) -> None:
        self._longest = LONGEST_DARK_S / interval
        self._state = np.zeros((MOST_PATHS, STATE))
        self._covariance = np.zeros((MOST_PATHS, STATE, STATE))
        self._hits = np.zeros(MOST_PATHS, np.int64)
        self._last = np.zeros(MOST_PATHS)
        self._number = np.full(MOST_PATHS, NONE)
        self._numbers = 0
        self._clock = 0.0
        self._frames: list[tuple[Array, NDArray[np.int64]]] = []

    def update(self, points: Array, clock: float) -> None:
        """
        Take the points of the next frame.

        Parameters
        ----------
        points : (n, 7) array
            As of `BlinkTracker.update`.
        clock : float
            Time of the frame, frame intervals.

        """
        points = np.ascontiguousarray(points)
        owner = np.full(len(points), NONE)
        dt, self._clock = clock - self._clock, clock
        _forget(self._covariance, self._last, self._number, clock - self._longest)
        paths, owned = _choices(
            self._state, self._covariance, self._hits, self._number, points, dt
        )
        self._numbers = _take(
            self._state, self._covariance, self._hits, self._last, self._number, points, owner,
            paths, owned, clock, self._numbers,
        )
        self._frames.append((points, owner))

    def paths(self, least: int) -> list[Path]:
        """Return the paths of so many points at least, those of the most first."""
        owners = [owner for _, owner in self._frames]
        if not owners or not sum(map(len, owners)):
            return []
        frames = np.repeat(np.arange(len(owners)), [len(each) for each in owners])
        owner = np.concatenate(owners)
        points = np.concatenate([each for each, _ in self._frames])
        which = np.concatenate([np.arange(len(each)) for each in owners])
        found = []
        for number, count in zip(*np.unique(owner[owner != NONE], return_counts=True)):
            if count >= least:
                own = owner == number
                found.append(Path(
                    frames[own], points[own, X], points[own, Y], points[own, FLUX],
                    points[own, FLUX_SIGMA], which[own],
                ))
        return sorted(found, key=lambda path: -len(path.frames))


@kernel
def _forget(
    covariance: Array, last: Array, number: NDArray[np.int64], oldest: float
) -> None:
    """End the paths that were not seen for long, or may be anywhere."""
    for row in range(number.size):
        if last[row] < oldest or covariance[row, 0, 0] > WIDEST * WIDEST:
            number[row] = NONE


@kernel
def _choices(
    state: Array, covariance: Array, hits: NDArray[np.int64], number: NDArray[np.int64],
    points: Array, dt: float,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Move the paths on; return which path may have which point, the likeliest first."""
    work = np.zeros((STATE, STATE))
    most = 8 * number.size
    paths, owned, cost = np.zeros(most, np.int64), np.zeros(most, np.int64), np.zeros(most)
    count = 0
    for row in range(number.size):
        if number[row] == NONE:
            continue
        predict(state[row], covariance[row], dt, 1.0, work)
        x, y, xx, xy, yy = project(state[row], covariance[row], 0.0)
        extra = BENT * BENT * (state[row, 2] ** 2 + state[row, 3] ** 2)
        for each in range(points.shape[0]):
            point = points[each]
            dx, dy = point[X] - x, point[Y] - y
            sxx, sxy, syy = xx + point[XX] + extra, xy + point[XY], yy + point[YY] + extra
            determinant = max(sxx * syy - sxy * sxy, 1e-12)
            distance = (syy * dx * dx - 2.0 * sxy * dx * dy + sxx * dy * dy) / determinant
            if distance < GATE and count < most:
                paths[count], owned[count] = row, each
                cost[count] = distance + np.log(determinant)
                if hits[row] >= SETTLED:
                    cost[count] -= HEAD_START
                count += 1
    order = np.argsort(cost[:count])
    return paths[:count][order], owned[:count][order]


@kernel
def _take(
    state: Array, covariance: Array, hits: NDArray[np.int64], last: Array,
    number: NDArray[np.int64], points: Array, owner: NDArray[np.int64],
    paths: NDArray[np.int64], owned: NDArray[np.int64], clock: float, numbers: int,
) -> int:
    """Give each path its point, and begin one at each that is left; return how many there are."""
    work = np.zeros((STATE, STATE))
    taken = np.zeros(number.size, np.bool_)
    for k in range(paths.size):
        row, each = paths[k], owned[k]
        if taken[row] or owner[each] != NONE:
            continue
        taken[row] = True
        owner[each] = number[row]
        point = points[each]
        x, y, xx, xy, yy = project(state[row], covariance[row], 0.0)
        extra = BENT * BENT * (state[row, 2] ** 2 + state[row, 3] ** 2)
        correct(
            state[row], covariance[row], 0.0, point[X] - x, point[Y] - y,
            xx + point[XX] + extra, xy + point[XY], yy + point[YY] + extra, work,
        )
        hits[row] += 1
        last[row] = clock
    row = 0
    for each in range(points.shape[0]):
        if owner[each] != NONE:
            continue
        while row < number.size and number[row] != NONE:
            row += 1
        if row == number.size:
            return numbers
        point = points[each]
        begin(
            state[row], covariance[row], point[X], point[Y], point[XX], point[XY], point[YY],
            FIRST_SPEED,
        )
        hits[row], last[row], number[row] = 1, clock, numbers
        owner[each] = numbers
        numbers += 1
    return numbers

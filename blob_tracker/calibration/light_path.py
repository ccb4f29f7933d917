"""The path of a light in space, as a spline in time whose pieces are where it was well seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ORDER = 4  # coefficients that a position takes part in: a cubic spline
BRIDGED = ORDER - 1  # intervals without rays: each coefficient has some in another interval
LEAST_INTERVALS = 6  # of a piece: in a shorter one little but its own ends is fitted


@dataclass(frozen=True)
class LightPath:
    """
    Uniform cubic B-spline over pieces of time.

    In the interval j of a piece, at the share u of it, the position is the sum of the
    coefficients c_j ... c_j+3 weighted by

        w = ((1 - u)^3, 3 u^3 - 6 u^2 + 4, -3 u^3 + 3 u^2 + 3 u + 1, u^3) / 6

    (de Boor, A Practical Guide to Splines, 1978, chapter X, for knots an equal time apart).

    Parameters
    ----------
    spacing : float
        Of the knots, s.
    starts : (p,) array
        Where each piece begins, s.
    intervals : (p,) array
        How many intervals each has.

    """

    spacing: float
    starts: Array
    intervals: NDArray[np.intp]

    @property
    def size(self) -> int:
        """How many coefficients there are; those of a piece follow each other."""
        return int(self.intervals.sum() + (ORDER - 1) * len(self.intervals))

    def place(self, times: Array) -> tuple[NDArray[np.intp], Array]:
        """
        Return where in the pieces instants are.

        Parameters
        ----------
        times : (n,) array
            s.

        Returns
        -------
        (n,) array, (n,) array
            The first of the four coefficients, -1 outside the pieces, and the share of the
            interval, 0 to 1.

        """
        piece = np.searchsorted(self.starts, times, side='right') - 1
        known = np.maximum(piece, 0)
        along = (times - self.starts[known]) / self.spacing
        interval = np.floor(along).astype(np.intp)
        inside = (piece >= 0) & (interval >= 0) & (interval < self.intervals[known])
        before = np.concatenate([[0], np.cumsum(self.intervals + ORDER - 1)[:-1]])
        return np.where(inside, before[known] + interval, -1), along - interval

    def weights(self, share: Array) -> Array:
        """Return the (n, 4) weights of the coefficients at shares of an interval."""
        u = share[:, None]
        return np.concatenate(
            [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3],
            axis=1,
        ) / 6.0

    def rates(self, share: Array) -> Array:
        """Return the (n, 4) weights with which they make the velocity, 1/s."""
        u = share[:, None]
        return np.concatenate(
            [-((1 - u) ** 2), 3 * u**2 - 4 * u, -3 * u**2 + 2 * u + 1, u**2], axis=1
        ) / (2.0 * self.spacing)


def covered(
    times: Sequence[Sequence[Array]], spacing: float, least: int = 2
) -> LightPath:
    """
    Return the pieces of time in which each light is seen by two cameras, but for short gaps.

    Or in which one camera sees so many lights.

    Parameters
    ----------
    times : sequence of sequences of (n,) arrays
        When each light was seen by each camera, s of one clock; or, in one group, each light.
    spacing : float
        Of the knots, s.
    least : int
        How many of a group see, or are seen, at once.

    Returns
    -------
    LightPath
        Without pieces if there is no such time.

    """
    together = [np.concatenate(list(each)) for each in times]
    start = max((float(each.min()) for each in together if len(each)), default=0.0)
    end = min((float(each.max()) for each in together if len(each)), default=0.0)
    count = max(int((end - start) / spacing) + 1, 0)
    enough = np.ones(count, dtype=bool)
    for of_light in times:
        cameras = np.zeros(count, dtype=np.intp)
        for each in of_light:
            number = np.floor((each - start) / spacing).astype(np.intp)
            number = number[(number >= 0) & (number < count)]
            cameras += np.bincount(number, minlength=count) > 0
        enough &= cameras >= least
    seen = np.flatnonzero(enough)
    for before, after in zip(seen[:-1], seen[1:], strict=True):  # the dark bits of a code
        if after - before <= BRIDGED + 1:
            enough[before:after] = True
    changes = np.diff(np.concatenate([[False], enough, [False]]).astype(np.int8))
    begins, ends = np.flatnonzero(changes == 1), np.flatnonzero(changes == -1)
    long = ends - begins >= LEAST_INTERVALS
    return LightPath(spacing, np.asarray(start + spacing * begins[long]), (ends - begins)[long])

"""How far the likelihood of a pose reaches along the way that is known the least."""

from __future__ import annotations

from blob_tracker.constellation.likelihood import linearise, solve
from blob_tracker.constellation.search import mirrored
from blob_tracker.kernel import Array, kernel
import numpy as np


@kernel
def far_end(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    used: Array, rates: Array, expected: Array, rotation: Array, position: Array, twist: Array,
    covariance: Array, ambiguous: float,
) -> float:
    """
    Take a pose to the other end of the valley of the likelihood in which it lies, in place.

    Seen nearly from the front, two poses of lights in a plane are in one valley, and no two
    maxima.

    Parameters
    ----------
    places, variances, rays, bases, noise, apart, used, rates, expected
        As `likelihood.fit` has them.
    rotation, position, twist
        The pose; hold the end afterwards.
    covariance : (6, 6) array
        Of the pose, at the bottom of the valley.
    ambiguous : float
        Of chi-square: no nearer ends count.

    Returns
    -------
    float
        What is minimised, at the end; inf where there is none.

    """
    other, place = np.empty((3, 3)), np.empty(3)
    mirrored(places, rotation, position, other, place)
    way, system = np.empty(6), covariance.copy()
    way[:3] = place - position
    turn_between(rotation, other, way[3:])
    weighed = way.copy()
    solve(system, weighed, 6)
    if np.sum(way * weighed) < ambiguous:
        return np.inf
    rotation[:], position[:] = other, place
    return linearise(
        places, variances, rays, bases, noise, apart, used, rates, expected, rotation, position,
        twist, np.empty((12, 12)), np.empty(12), np.empty(len(rays)),
    )


@kernel
def turn_between(before: Array, after: Array, turn: Array) -> None:
    """Fill in the turn from one rotation to another, as a rotation vector, rad."""
    by = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                by[i, j] += after[i, k] * before[j, k]
    cosine = 0.5 * (by[0, 0] + by[1, 1] + by[2, 2] - 1.0)
    turn[0], turn[1], turn[2] = (
        0.5 * (by[2, 1] - by[1, 2]), 0.5 * (by[0, 2] - by[2, 0]), 0.5 * (by[1, 0] - by[0, 1]))
    sine = np.sqrt(np.sum(turn**2))
    if sine > 1e-6:
        turn *= np.arctan2(sine, cosine) / sine
    elif cosine < 0.0:  # half a turn: the axis is the greatest column of by + 1
        axis = 0
        for i in range(1, 3):
            axis = i if by[i, i] > by[axis, axis] else axis
        for i in range(3):
            turn[i] = by[i, axis] + (1.0 if i == axis else 0.0)
        turn *= np.pi / np.sqrt(np.sum(turn**2))

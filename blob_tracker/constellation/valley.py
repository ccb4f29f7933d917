"""How far the likelihood of a pose reaches along the ways that are known the least."""

from __future__ import annotations

from blob_tracker.constellation.likelihood import linearise, move, solve
from blob_tracker.constellation.search import diagonalise, invert, mirrored
from blob_tracker.kernel import Array, kernel
import numpy as np

FAR = 5  # standard deviations that a way is followed, one step each
STRAIGHT = 0.75  # of its square, that chi-square has grown by there: else the valley bends
# Greatest sigma of a turn, rad, up to which its error is Gaussian, whatever the lights are.
SURE_RAD = 0.01


@kernel
def far_end(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    used: Array, rates: Array, expected: Array, rotation: Array, position: Array, twist: Array,
    ambiguous: float,
) -> bool:
    """
    Take a pose to a far end of the valley of the likelihood in which it lies, in place.

    Seen nearly from the front, two poses of lights in a plane are in one valley, and no two
    maxima. And a valley may bend: along a turn that is followed for five standard deviations,
    with all else where it is likeliest, chi-square has to grow as the covariance says.

    Parameters
    ----------
    places, variances, rays, bases, noise, apart, used, rates, expected
        As `likelihood.fit` has them.
    rotation, position, twist
        The pose; hold the end afterwards.
    ambiguous : float
        Of chi-square: less does not tell an end from the pose.

    Returns
    -------
    bool
        Whether there is one.

    """
    size = 12 if rates[0] > 0.0 else 6
    seen = np.empty(len(rays))
    information, covariance = np.empty((12, 12)), np.empty((12, 12))
    least = linearise(
        places, variances, rays, bases, noise, apart, used, rates, expected, rotation, position,
        twist, information, np.empty(12), seen,
    )
    if not invert(information, size, covariance):
        return False
    of_turn, axes = covariance[3:6, 3:6].copy(), np.empty((3, 3))
    diagonalise(of_turn, axes)
    other, place = np.empty((3, 3)), np.empty(3)
    mirrored(places, rotation, position, other, place)
    # Directions, each by what is held along it: turns about three axes, and the mirrored pose.
    held = np.zeros((4, 12))
    for i in range(3):
        held[i, 3:6] = axes[:, i]
    way = np.zeros(12)
    way[:3] = place - position
    turn_between(rotation, other, way[3:6])
    for i in range(size):
        for j in range(6):
            held[3, i] += information[i, j] * way[j]
    if np.sum(way * held[3]) > ambiguous and linearise(
        places, variances, rays, bases, noise, apart, used, rates, expected, other, place, twist,
        np.empty((12, 12)), np.empty(12), seen,
    ) <= least + ambiguous:
        rotation[:], position[:] = other, place
        return True
    if max(of_turn[0, 0], of_turn[1, 1], of_turn[2, 2]) < SURE_RAD**2:
        return False
    start, begin, motion = rotation.copy(), position.copy(), twist.copy()
    for each in range(4):
        step = np.zeros(12)
        for i in range(size):
            for j in range(size):
                step[i] += covariance[i, j] * held[each, j]
        step /= np.sqrt(max(np.sum(step * held[each]), 1e-300))
        for sign in (-1.0, 1.0):
            rotation[:], position[:], twist[:] = start, begin, motion
            cost = _followed(
                places, variances, rays, bases, noise, apart, used, rates, expected, rotation,
                position, twist, sign * step, held[each],
            )
            if cost - least < STRAIGHT * FAR**2:
                return True
    rotation[:], position[:], twist[:] = start, begin, motion
    return False


@kernel
def _followed(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    used: Array, rates: Array, expected: Array, rotation: Array, position: Array, twist: Array,
    step: Array, held: Array,
) -> float:
    """
    Take a pose some steps along a valley, in place; return what is minimised there.

    After each of them all that leaves the direction `held` alone goes to where it is likeliest.
    """
    size = 12 if rates[0] > 0.0 else 6
    information, gradient, seen = np.empty((12, 12)), np.empty(12), np.empty(len(rays))
    new_rotation, new_position, new_twist = np.empty((3, 3)), np.empty(3), np.empty(6)
    cost = 0.0
    for _ in range(FAR):
        move(rotation, position, twist, step, size, new_rotation, new_position, new_twist)
        rotation[:], position[:], twist[:] = new_rotation, new_position, new_twist
        linearise(
            places, variances, rays, bases, noise, apart, used, rates, expected, rotation,
            position, twist, information, gradient, seen,
        )
        system, across = information.copy(), held.copy()
        solve(information, gradient, size)
        solve(system, across, size)
        along, reach = 0.0, 1e-300
        for i in range(size):
            along += held[i] * gradient[i]
            reach += held[i] * across[i]
        move(
            rotation, position, twist, gradient - across * along / reach, size, new_rotation,
            new_position, new_twist,
        )
        rotation[:], position[:], twist[:] = new_rotation, new_position, new_twist
        cost = linearise(
            places, variances, rays, bases, noise, apart, used, rates, expected, rotation,
            position, twist, information, gradient, seen,
        )
    return cost


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

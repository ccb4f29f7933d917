"""All poses of greatest likelihood: starts by three rays each, climbed from."""

from __future__ import annotations

from blob_tracker.constellation.candidates import candidates
from blob_tracker.constellation.likelihood import fit, linearise, solve
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

OUTLIERS = 5  # of so many lights one may be another's
ROUNDS = 4  # in which bearings of other lights settle
NONE = -1  # no bearing
SAME_RAD = 1e-3  # poses that are turned less apart are one
SWEEPS = 12  # of Jacobi's turns, which square what is left


@kernel
def search(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    rates: Array, expected: Array, triples: NDArray[np.int64], price: float, gates: Array,
    odd: bool, rotations: Array, positions: Array, twists: Array, covariances: Array,
    used: Array, costs: Array,
) -> int:
    """
    Find the poses of greatest likelihood that bearings allow, the first by the best start.

    Parameters
    ----------
    places, variances, rays, bases, noise, apart, rates, expected
        As `likelihood.fit` has them.
    triples : (m, 3) int array
        The bearings that are taken together.
    price : float
        Of a bearing that does not fit, as `candidates` has it.
    gates : (k + 1,) array
        Greatest chi-square of a pose of so many bearings; the first of all is that of a bearing.
    odd : bool
        Whether bearings may be of other lights.
    rotations, positions, twists, covariances, used, costs : (n, ...) arrays
        Are filled with the poses, one more than starts are tried: body's frame to optical frame,
        m, the twist, the (12, 12) covariance as that of `fit`, 1 of bearings that count, and what
        was minimised.

    Returns
    -------
    int
        How many are filled.

    """
    most = len(costs) - 1
    starts, places_of = np.empty((most, 3, 3)), np.empty((most, 3))
    doubt = variances.copy()
    if rates[0] > 0.0:  # what a body that moves does meanwhile is not in the pose of three rays
        speed2, rate2 = rates[0]**2, rates[1]**2
        for i in range(3):
            speed2 += expected[i]**2
            rate2 += expected[3 + i]**2
        for k in range(len(rays)):
            size2 = places[k, 0]**2 + places[k, 1]**2 + places[k, 2]**2
            doubt[k] += (speed2 + rate2 * size2) * apart[k]**2
    count = candidates(
        places, doubt, rays, bases, noise, apart, expected, triples, price, starts, places_of)
    found = 0
    for each in range(count + 1 if count else 0):
        rotation, position = rotations[found], positions[found]
        if each < count:
            rotation[:], position[:] = starts[each], places_of[each]
        else:
            mirrored(places, starts[0], places_of[0], rotation, position)
        twists[found] = expected
        costs[found] = climb(
            places, variances, rays, bases, noise, apart, rates, expected, gates, odd,
            rotation, position, twists[found], used[found], covariances[found], NONE,
        )
        found += _is_new(rotations, costs, found)
    best = 0
    for each in range(1, found):
        best = each if costs[each] < costs[best] else best
    if found == 0 or np.sum(used[best]) != len(rays) - 1:
        return found
    for left_out in range(len(rays)):  # it may be another one that is odd
        if used[best, left_out] == 0.0 or found == len(costs):
            continue
        rotations[found], positions[found] = rotations[best], positions[best]
        twists[found] = twists[best]
        costs[found] = climb(
            places, variances, rays, bases, noise, apart, rates, expected, gates, False,
            rotations[found], positions[found], twists[found], used[found], covariances[found],
            left_out,
        )
        found += _is_new(rotations, costs, found)
    return found


@kernel
def _is_new(rotations: Array, costs: Array, found: int) -> int:
    """Return 1 if the last of some poses is one, and none of those before, else 0."""
    if not costs[found] < np.inf:
        return 0
    for other in range(found):
        if 3.0 - np.sum(rotations[found] * rotations[other]) < SAME_RAD**2:
            return 0
    return 1


@kernel
def climb(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    rates: Array, expected: Array, gates: Array, odd: bool, rotation: Array, position: Array,
    twist: Array, used: Array, covariance: Array, left_out: int,
) -> float:
    """
    Take a start to the greatest likelihood, in place; return what was minimised, inf for no pose.

    Where all bearings do not fit, the one in five that fits the start the least is left out, and
    afterwards whatever does not fit, until that settles. Or it is said which one, with `odd`
    False. See `search`.
    """
    count = len(rays)
    chi2, information = np.empty(count), np.empty((12, 12))
    used[:] = 1.0
    inside = count
    if left_out != NONE:
        used[left_out], inside = 0.0, count - 1
    start, place = rotation.copy(), position.copy()
    cost = fit(
        places, variances, rays, bases, noise, apart, used, rates, expected, rotation, position,
        twist, information, chi2,
    )
    if odd and count >= OUTLIERS and not cost <= gates[count]:
        rotation[:], position[:], twist[:] = start, place, expected  # it was drawn away
        _leave_out_the_worst(
            places, variances, rays, bases, noise, apart, expected, rotation, position, used)
        settled = False
        for _ in range(ROUNDS):
            cost = fit(
                places, variances, rays, bases, noise, apart, used, rates, expected, rotation,
                position, twist, information, chi2,
            )
            settled, inside = True, 0
            for k in range(count):
                fits = 1.0 if chi2[k] < gates[0] else 0.0
                settled = settled and fits == used[k]
                used[k] = fits
                inside += int(fits)
            if settled:
                break
            if inside < count - count // OUTLIERS:
                return np.inf
        if not settled:
            return np.inf
    if not cost <= gates[inside]:  # nor NaN
        return np.inf
    for k in range(count):
        along = 0.0
        for i in range(3):
            point = position[i]
            for j in range(3):
                point += rotation[i, j] * places[k, j]
            along += rays[k, i] * point
        if used[k] > 0.0 and along < 0.0:
            return np.inf
    if not invert(information, 12 if rates[0] > 0.0 else 6, covariance):
        return np.inf
    return cost


@kernel
def _leave_out_the_worst(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    expected: Array, rotation: Array, position: Array, used: Array,
) -> None:
    """Let all bearings count but the one in five that fits a start the least."""
    count = len(rays)
    chi2 = np.empty(count)
    linearise(
        places, variances, rays, bases, noise, apart, used, np.zeros(2), expected, rotation,
        position, expected, np.empty((12, 12)), np.empty(12), chi2,
    )
    for _ in range(count // OUTLIERS):
        worst = 0
        for k in range(count):
            if not chi2[k] <= chi2[worst]:
                worst = k
        used[worst], chi2[worst] = 0.0, -1.0


@kernel
def exchanges(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    rates: Array, expected: Array, triples: NDArray[np.int64], price: float, gates: Array,
    costs: Array,
) -> None:
    """
    Fill in what the best pose costs if two lights have each other's bearings; inf for none.

    Parameters
    ----------
    costs : (k, k) array
        By the two lights, the first of them before the other.
    places, variances, rays, bases, noise, apart, rates, expected, triples, price, gates
        As `search` has them.

    """
    count = len(rays)
    costs[:] = np.inf
    rotations, positions, twists = np.empty((2, 3, 3)), np.empty((2, 3)), np.empty((2, 6))
    covariances, used = np.empty((2, 12, 12)), np.empty((2, count))
    found = np.empty(2)
    for i in range(count):
        for j in range(i + 1, count):
            order = np.arange(count)
            order[i], order[j] = j, i
            number = search(
                places[order], variances[order], rays, bases, noise, apart, rates, expected,
                triples, price, gates, False, rotations, positions, twists, covariances, used,
                found,
            )
            for each in range(number):
                costs[i, j] = min(costs[i, j], found[each])


@kernel
def mirrored(
    places: Array, rotation: Array, position: Array, other: Array, place: Array
) -> None:
    """
    Fill in the other pose in which lights in a plane look nearly the same.

    Depths about the middle are turned over: R' = (I - 2 v v^T) R (I - 2 n n^T) with the line of
    sight v and the body's thinnest direction n.
    """
    middle, thin = np.zeros(3), np.empty(3)
    for k in range(len(places)):
        middle += places[k] / len(places)
    spread(places, thin)
    centre = np.empty(3)
    for i in range(3):
        centre[i] = position[i]
        for j in range(3):
            centre[i] += rotation[i, j] * middle[j]
    sight = centre / np.sqrt(np.sum(centre**2))
    turned = np.empty((3, 3))
    for j in range(3):
        along = sight[0] * rotation[0, j] + sight[1] * rotation[1, j] + sight[2] * rotation[2, j]
        for i in range(3):
            turned[i, j] = rotation[i, j] - 2.0 * sight[i] * along
    for i in range(3):
        along = turned[i, 0] * thin[0] + turned[i, 1] * thin[1] + turned[i, 2] * thin[2]
        place[i] = centre[i]
        for j in range(3):
            other[i, j] = turned[i, j] - 2.0 * along * thin[j]
            place[i] -= other[i, j] * middle[j]


@kernel
def spread(places: Array, thin: Array) -> float:
    """
    Fill in the direction in which points are spread the least.

    Returns
    -------
    float
        The second greatest spread over the greatest, both squared: 0 of points in one line.

    """
    middle, moments, axes = np.zeros(3), np.zeros((3, 3)), np.empty((3, 3))
    for k in range(len(places)):
        middle += places[k] / len(places)
    for k in range(len(places)):
        for i in range(3):
            for j in range(3):
                moments[i, j] += (places[k, i] - middle[i]) * (places[k, j] - middle[j])
    diagonalise(moments, axes)
    least = most = 0
    for i in range(1, 3):
        least = i if moments[i, i] < moments[least, least] else least
        most = i if moments[i, i] >= moments[most, most] else most
    for i in range(3):
        thin[i] = axes[i, least]
    return moments[3 - least - most, 3 - least - most] / moments[most, most]


@kernel
def diagonalise(moments: Array, axes: Array) -> None:
    """Turn a symmetric (3, 3) matrix in place until it is diagonal; fill in the axes, a column."""
    for i in range(3):
        for j in range(3):
            axes[i, j] = 1.0 if i == j else 0.0
    for _ in range(SWEEPS):
        for i in range(2):
            for j in range(i + 1, 3):
                if moments[i, j] == 0.0:
                    continue
                half = 0.5 * np.arctan2(2.0 * moments[i, j], moments[j, j] - moments[i, i])
                sine, cosine = np.sin(half), np.cos(half)
                for k in range(3):
                    one, two = moments[k, i], moments[k, j]
                    moments[k, i], moments[k, j] = cosine * one - sine * two, (
                        sine * one + cosine * two)
                for k in range(3):
                    one, two = moments[i, k], moments[j, k]
                    moments[i, k], moments[j, k] = cosine * one - sine * two, (
                        sine * one + cosine * two)
                    one, two = axes[k, i], axes[k, j]
                    axes[k, i], axes[k, j] = cosine * one - sine * two, sine * one + cosine * two


@kernel
def invert(matrix: Array, size: int, inverse: Array) -> bool:
    """Fill in the inverse of a positive definite matrix; return False where it is none."""
    for i in range(size):
        if not matrix[i, i] > 0.0:
            return False
    for i in range(size):
        system, column = matrix.copy(), np.zeros(size)
        column[i] = 1.0
        solve(system, column, size)
        for j in range(size):
            inverse[j, i] = column[j]
            if not np.isfinite(column[j]):
                return False
    return True

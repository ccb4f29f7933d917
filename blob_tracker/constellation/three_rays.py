"""The poses in which three lights lie on three rays."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

MOST = 8  # poses that are tried: both u of each of four v
ROUNDS = 30  # of the search for the four roots, which doubles its digits in most
CLOSE = 1e-6  # of a root: the likelihood does the rest
NEARLY_REAL = 0.3  # noise makes a complex pair of two equal roots
FITS = 0.1  # of a squared side, by which it may be missed: the likelihood decides later
EMPTY = 1e-12


@kernel
def three_rays(places: Array, rays: Array, rotations: Array, positions: Array) -> int:
    """
    Find the poses of three lights on three rays of any directions (P3P).

    With the sides a, b, c opposite to the lights 1, 2, 3 and the cosines of the angles between
    the rays, the distances s1, u s1, v s1 follow from a quartic of v (Grunert 1841; as Haralick
    et al., Int. J. Computer Vision 13 (1994) 331, eq. 9, write it). u is taken of the side c,
    u^2 - 2 u cos(gamma) + 1 = c^2 / s1^2, which does not divide by zero where the lights are
    seen symmetrically, as eq. 8 there does.

    Parameters
    ----------
    places : (3, 3) array
        Of the lights in the body's frame, m.
    rays : (3, 3) array
        Unit vectors.
    rotations, positions : (8, 3, 3), (8, 3) arrays
        Are filled: body's frame to optical frame, and the body's origin, m.

    Returns
    -------
    int
        How many of them are.

    """
    aa = np.sum((places[1] - places[2])**2)
    bb = np.sum((places[0] - places[2])**2)
    cc = np.sum((places[0] - places[1])**2)
    alpha = np.sum(rays[1] * rays[2])
    beta = np.sum(rays[0] * rays[2])
    gamma = np.sum(rays[0] * rays[1])
    q, p = (aa - cc) / bb, (aa + cc) / bb
    fourth = (q - 1.0)**2 - 4.0 * cc / bb * alpha**2
    third = 4.0 * (
        q * (1.0 - q) * beta - (1.0 - p) * alpha * gamma + 2.0 * cc / bb * alpha**2 * beta
    )
    second = 2.0 * (
        q**2 - 1.0 + 2.0 * q**2 * beta**2 + 2.0 * (bb - cc) / bb * alpha**2
        - 4.0 * p * alpha * beta * gamma + 2.0 * (bb - aa) / bb * gamma**2
    )
    first = 4.0 * (
        -q * (1.0 + q) * beta + 2.0 * aa / bb * gamma**2 * beta - (1.0 - p) * alpha * gamma
    )
    zeroth = (1.0 + q)**2 - 4.0 * aa / bb * gamma**2
    if abs(fourth) < EMPTY:
        fourth = EMPTY
    roots = _roots(third / fourth, second / fourth, first / fourth, zeroth / fourth)
    own = _axes(places)
    points = np.empty((3, 3))
    found = 0
    for root in roots:
        v = root.real
        if v <= 0.0 or abs(root.imag) > NEARLY_REAL * v:
            continue
        distance2 = bb / max(1.0 + v**2 - 2.0 * v * beta, EMPTY)
        half = np.sqrt(max(gamma**2 - 1.0 + cc / distance2, 0.0))
        for sign in (-1.0, 1.0):
            u = gamma + sign * half
            missed = abs(distance2 * (u**2 + v**2 - 2.0 * u * v * alpha) / aa - 1.0)
            if u <= 0.0 or missed > FITS:
                continue
            distance = np.sqrt(distance2)
            points[0] = distance * rays[0]
            points[1] = u * distance * rays[1]
            points[2] = v * distance * rays[2]
            seen = _axes(points)
            rotation = rotations[found]
            for i in range(3):
                for j in range(3):
                    rotation[i, j] = (
                        seen[0, i] * own[0, j] + seen[1, i] * own[1, j] + seen[2, i] * own[2, j]
                    )
            for i in range(3):
                positions[found, i] = (points[0, i] + points[1, i] + points[2, i]) / 3.0
                for j in range(3):
                    middle = (places[0, j] + places[1, j] + places[2, j]) / 3.0
                    positions[found, i] -= rotation[i, j] * middle
            found += 1
    return found


@kernel
def _roots(third: float, second: float, first: float, zeroth: float) -> NDArray[np.complex128]:
    """Return the four roots of a quartic at once (Durand-Kerner)."""
    roots = np.empty(4, dtype=np.complex128)
    size = 1.0 + abs(third)
    roots[0] = 1.0
    for i in range(1, 4):
        roots[i] = roots[i - 1] * (0.4 + 0.9j)
    for _ in range(ROUNDS):
        change = 0.0
        for i in range(4):
            x = roots[i]
            value = (((x + third) * x + second) * x + first) * x + zeroth
            apart = 1.0 + 0.0j
            for j in range(4):
                if j != i:
                    apart *= x - roots[j]
            if abs(apart) < 1e-300:
                apart = 1e-300 + 0.0j
            step = value / apart
            roots[i] = x - step
            change = max(change, abs(step))
        if change < CLOSE * size:
            break
    return roots


@kernel
def _axes(points: Array) -> Array:
    """Return three orthogonal unit vectors, one a row, that turn with three points."""
    axes = np.empty((3, 3))
    axes[0] = points[1] - points[0]
    axes[0] /= np.sqrt(np.sum(axes[0]**2))
    other = points[2] - points[0]
    axes[2, 0] = axes[0, 1] * other[2] - axes[0, 2] * other[1]
    axes[2, 1] = axes[0, 2] * other[0] - axes[0, 0] * other[2]
    axes[2, 2] = axes[0, 0] * other[1] - axes[0, 1] * other[0]
    axes[2] /= np.sqrt(np.sum(axes[2]**2)) + 1e-300
    axes[1, 0] = axes[2, 1] * axes[0, 2] - axes[2, 2] * axes[0, 1]
    axes[1, 1] = axes[2, 2] * axes[0, 0] - axes[2, 0] * axes[0, 2]
    axes[1, 2] = axes[2, 0] * axes[0, 1] - axes[2, 1] * axes[0, 0]
    return axes

"""Poses from which the likelihood may be climbed, by three rays at a time."""

from __future__ import annotations

from blob_tracker.constellation.likelihood import score
from blob_tracker.constellation.three_rays import MOST, three_rays
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

ALIKE_RAD = 0.05  # candidates that are turned less apart lead to the same pose


@kernel
def candidates(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    twist: Array, triples: NDArray[np.int64], most_chi2: float, rotations: Array, positions: Array,
) -> int:
    """
    Find the best poses of three rays, by what all bearings say of them.

    The score is sum min(chi2, most_chi2): a bearing that is another light's costs a fixed price
    (MSAC; Torr & Zisserman, Computer Vision and Image Understanding 78 (2000) 138, eq. 9).

    Parameters
    ----------
    places, variances, rays, bases, noise, apart
        As `likelihood.fit` has them.
    twist : (6,) array
        How the body moves, m/s and rad/s.
    triples : (m, 3) int array
        The bearings that are taken together.
    most_chi2 : float
        Price of a bearing that does not fit.
    rotations, positions : (n, 3, 3), (n, 3) arrays
        Are filled with the best, the first one before all others.

    Returns
    -------
    int
        How many are filled.

    """
    found_rotations, found_positions = np.empty((MOST, 3, 3)), np.empty((MOST, 3))
    scores = np.full(len(rotations), np.inf)
    kept = 0
    for triple in triples:
        number = three_rays(places[triple], rays[triple], found_rotations, found_positions)
        for each in range(number):
            misfit = score(
                places, variances, rays, bases, noise, apart, found_rotations[each],
                found_positions[each], twist, most_chi2,
            )
            kept = _keep(
                found_rotations[each], found_positions[each], misfit,
                rotations, positions, scores, kept,
            )
    return kept


@kernel
def _keep(
    rotation: Array, position: Array, score: float,
    rotations: Array, positions: Array, scores: Array, kept: int,
) -> int:
    """Put a candidate among the best in order, alone of its like; return how many they are."""
    for i in range(kept):
        if 3.0 - np.sum(rotation * rotations[i]) < ALIKE_RAD**2:
            if score >= scores[i]:
                return kept
            for j in range(i, kept - 1):
                rotations[j], positions[j], scores[j] = (
                    rotations[j + 1], positions[j + 1], scores[j + 1])
            kept -= 1
            break
    place = kept
    while place > 0 and scores[place - 1] > score:
        place -= 1
    if place == len(scores):
        return kept
    kept = min(kept + 1, len(scores))
    for j in range(kept - 1, place, -1):
        rotations[j], positions[j], scores[j] = rotations[j - 1], positions[j - 1], scores[j - 1]
    rotations[place], positions[place], scores[place] = rotation, position, score
    return kept

"""The noise that a JPEG's rounding of cosine coefficients adds to a blob's place."""

from __future__ import annotations

import math
from typing import Any

from blob_tracker.segmentation.candidate import Candidate
import numpy as np
from numpy.typing import NDArray

SIDE = 8  # px of a block
REACH_SIGMA = 4.0  # sigma to either side: beyond it a Gaussian has no slope
STEPS = 16  # of a DN, in which the noise is told: what a window's message has room for
# The orthonormal cosine transform of 8 samples (ITU-T T.81, A.3.3), by coefficient and sample.
_COSINES = np.sqrt(2.0 / SIDE) * np.cos(
    np.pi / SIDE * np.outer(np.arange(SIDE), np.arange(SIDE) + 0.5)
)
_COSINES[0] /= math.sqrt(2.0)
# Steps of the luma at quality 50 (ITU-T T.81, table K.1), which encoders scale.
_STANDARD = np.array([
    [16, 11, 10, 16, 24, 40, 51, 61],
    [12, 12, 14, 19, 26, 58, 60, 55],
    [14, 13, 16, 24, 40, 57, 69, 56],
    [14, 17, 22, 29, 51, 87, 80, 62],
    [18, 22, 37, 56, 68, 109, 103, 77],
    [24, 35, 55, 64, 81, 104, 113, 92],
    [49, 64, 78, 87, 103, 121, 120, 101],
    [72, 92, 95, 98, 112, 100, 103, 99],
])


def compression_noise(
    quantisation: NDArray[Any] | None, candidate: Candidate,
    raw_steps: NDArray[np.float64] | None = None,
) -> float:
    """
    Return the standard deviation of a white noise that moves the blob as the rounding does.

    A coefficient that is kept in steps of q is off by q^2 / 12 in the mean square, but by no more
    than its own square where it is rounded to nothing. Of these errors the place takes those that
    look like the blob's own slope D = dG/dx: with the blob's coefficients c_ij

        sum_ij D_ij^2 min(q_ij^2 / 12, c_ij^2 + 1/12) / sum_ij D_ij^2

    over all blocks, the mean of that along x and along y. A wide blob has its slope in the
    low coefficients, whose steps are fine, a narrow one in all.

    Parameters
    ----------
    quantisation : (8, 8) array or None
        Steps q, DN, by row and column; None of a picture that was not compressed.
    candidate : Candidate
        The blob; the first block begins at the frame's first pixel.
    raw_steps : (2, n) array or None
        Of pixels that were made linear, see `Frame`: the rounding is as large as it is half way
        up the blob, where its slope is.

    Returns
    -------
    float
        DN, a multiple of 1/16; 0 where nothing was compressed.

    """
    if quantisation is None:
        return 0.0
    raw_step = 1.0
    if raw_steps is not None:
        raw_step = float(np.interp(candidate.background + 0.5 * candidate.amplitude, *raw_steps))
    steps = (raw_step * np.asarray(quantisation, dtype=float)) ** 2 / 12.0
    across, slope_x = _coefficients(candidate.x, candidate.sigma_x)
    down, slope_y = _coefficients(candidate.y, candidate.sigma_y)
    # (blocks down, blocks across, rows, columns)
    pulse = candidate.amplitude * np.einsum('ai,bj->abij', down, across)
    error = np.minimum(steps, pulse**2 + raw_step**2 / 12.0)
    variance = 0.0
    for y, x in ((down, slope_x), (slope_y, across)):
        weight = np.einsum('ai,bj->abij', y**2, x**2)
        variance += 0.5 * float((weight * error).sum() / weight.sum())
    return round(STEPS * math.sqrt(variance)) / STEPS


def standard_quantisation(quality: int) -> NDArray[np.uint16]:
    """
    Return the steps of the luma that libjpeg takes for a quality.

    Parameters
    ----------
    quality : int
        1 to 100.

    Returns
    -------
    (8, 8) array
        DN, by row and column.

    """
    percent = 5000 // quality if quality < 50 else 200 - 2 * quality
    return np.clip((_STANDARD * percent + 50) // 100, 1, 255).astype(np.uint16)


def _coefficients(
    centre: float, sigma: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (blocks, 8) coefficients of a unit Gaussian along an axis, and of its slope."""
    first = math.floor((centre - REACH_SIGMA * sigma) / SIDE)
    last = math.floor((centre + REACH_SIGMA * sigma) / SIDE)
    offset = np.arange(SIDE * first, SIDE * (last + 1)) - centre
    bell = np.exp(-0.5 * (offset / sigma) ** 2)
    slope = bell * offset / sigma**2
    return bell.reshape(-1, SIDE) @ _COSINES.T, slope.reshape(-1, SIDE) @ _COSINES.T

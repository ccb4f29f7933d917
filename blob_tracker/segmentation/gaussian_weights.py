"""Gaussian weights along an axis, with the distances that moments take."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
import numpy as np

VECTOR = 8  # sums over few pixels are fastest where they go over whole vectors of the processor


@kernel
def fill_weights(
    out: Array, count: int, first: int, middle: float, sigma: float
) -> tuple[int, float]:
    """
    Fill in the weights of pixels at d from the middle, w = exp(-d^2 / 2 sigma^2), w d and w d^2.

    From one pixel to the next w grows by exp(-(d + 1/2) / sigma^2), and that by
    exp(-1 / sigma^2): three exponentials do for all, to 1e-13.

    Parameters
    ----------
    out : (3, n) array
        Gets them. Beyond the window they are 0, up to a whole number of vectors.
    count, first : int
        How many pixels, and the place of the first one, px.
    middle, sigma : float
        Place and width of the Gaussian, px.

    Returns
    -------
    padded : int
        How many weights there are with those that are 0.
    norm : float
        Sum of w^2.

    """
    steepness, d = 1.0 / (sigma * sigma), first - middle
    weight = np.exp(-0.5 * steepness * d * d)
    growth, bend = np.exp(-steepness * (d + 0.5)), np.exp(-steepness)
    norm = 0.0
    for i in range(count):
        out[0, i], out[1, i], out[2, i] = weight, weight * d, weight * d * d
        norm += weight * weight
        weight *= growth
        growth *= bend
        d += 1.0
    padded = np.uint64((count + VECTOR - 1) // VECTOR) * np.uint64(VECTOR)
    for i in range(np.uint64(count), padded):
        out[0, i] = out[1, i] = out[2, i] = 0.0
    return padded, norm

"""How likely the pixels of a window are if what they show is a random texture."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Correlation lengths, px: a lump as small as a pulse, one of some pulses, and edges or slopes.
SMOOTH = (2.0, 1.0, 4.0)  # of exp(-d^2 / 2 l^2)
ROUGH = (3.0, 30.0)  # of exp(-|d| / l) along x times the same along y
STRENGTHS = np.concatenate([[0.0], np.geomspace(0.02, 5000.0, 14)])  # variance over the noise's


class Modes(NamedTuple):
    """
    The modes of the textures of each correlation in windows of one size.

    Parameters
    ----------
    down, across : (n, h, h) and (n, w, w) arrays
        Eigenvectors of the correlations along y and along x.
    rows, columns : (n, h) and (n, w) arrays
        Their eigenvalues.

    """

    down: Array
    rows: Array
    across: Array
    columns: Array


def log_likelihood_of_texture(pixels: Floats, variance: float) -> float:
    """
    Return the likelihood of pixels that are a random texture and noise, of the best correlation.

    The texture is a Gaussian process of the mean of the pixels, whose covariance is a product
    of one along x and one along y, K = K_y (x) K_x with the eigenvalues k_i k_j. In the basis
    of the eigenvectors the pixels c_ij are independent (Rasmussen and Williams, Gaussian
    Processes for Machine Learning (2006), eq. 2.30 and 5.8):

        -2 ln L = sum_ij c_ij^2 / (V + S k_i k_j) + ln(V + S k_i k_j)

    The strength S is the likeliest of those above.

    Parameters
    ----------
    pixels : (h, w) array
        DN.
    variance : float
        V, of a pixel's noise, DN^2.

    """
    return float(log_likelihood(pixels, modes_of(pixels), variance, math.inf))


@kernel
def log_likelihood(pixels: Array, modes: Modes, variance: float, enough: float) -> float:
    """Return that of `log_likelihood_of_texture`, or of the first that is `enough`."""
    best = -math.inf
    for k in range(modes.rows.shape[0]):
        deviance = _least_deviance(
            pixels, modes.down[k], modes.rows[k], modes.across[k], modes.columns[k], variance,
            -2.0 * enough,
        )
        best = max(best, -0.5 * deviance)
        if best >= enough:
            break
    return best


@kernel
def _least_deviance(
    pixels: Array, down: Array, rows: Array, across: Array, columns: Array,
    variance: float, enough: float,
) -> float:
    """Return -2 ln L of the likeliest strength, or of the first as likely, by the modes."""
    height, width = pixels.shape
    mean = pixels.sum() / pixels.size
    half, squares = np.zeros((height, width)), np.zeros((height, width))
    for i in range(height):
        for j in range(height):
            for k in range(width):
                half[i, k] += down[j, i] * (pixels[j, k] - mean)
        for j in range(width):
            for k in range(width):
                squares[i, k] += half[i, j] * across[j, k]
        for k in range(width):
            squares[i, k] *= squares[i, k]
    # In the order in which one is soonest found that is enough: from the pixels' own scatter.
    total = 0.0
    for row in squares:
        for square in row:
            total += square
    nearest = np.searchsorted(STRENGTHS, total / (pixels.size * variance) - 1.0)
    least = math.inf
    for index in range(STRENGTHS.size):
        strength = STRENGTHS[(nearest + index) % STRENGTHS.size]
        deviance = 0.0
        for i in range(height):
            product = 1.0
            for k in range(width):
                total = variance * (1.0 + strength * rows[i] * columns[k])
                deviance += squares[i, k] / total
                product *= total
                # One logarithm serves several pixels; with more the product might overflow.
                if k % 8 == 7 or k == width - 1:
                    deviance += math.log(product)
                    product = 1.0
        least = min(least, deviance)
        if least <= enough:
            break
    return least


def modes_of(pixels: Floats) -> Modes:
    """Return the modes in windows of the size of this one."""
    return modes_of_size(*pixels.shape)


@functools.lru_cache
def modes_of_size(height: int, width: int) -> Modes:
    """Return the modes in windows of (h, w) px."""
    return Modes(*_modes(height), *_modes(width))


@functools.lru_cache
def _modes(count: int) -> tuple[Floats, Floats]:
    """Return eigenvectors (n, count, count) and eigenvalues (n, count) along one axis."""
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    found = [np.linalg.eigh(np.exp(-((distance / length) ** 2) / 2.0)) for length in SMOOTH]
    found += [np.linalg.eigh(np.exp(-(distance / length))) for length in ROUGH]
    values, vectors = zip(*found)
    return np.array(vectors), np.maximum(values, 0.0)

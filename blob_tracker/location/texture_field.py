"""How likely the pixels of a window are if what they show is a random texture."""

from __future__ import annotations

from collections.abc import Iterator
import functools
import math

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Correlation lengths, px: a lump as small as a pulse, one of some pulses, and edges or slopes.
SMOOTH = (2.0, 1.0, 4.0)  # of exp(-d^2 / 2 l^2)
ROUGH = (3.0, 30.0)  # of exp(-|d| / l) along x times the same along y
STRENGTHS = np.concatenate([[0.0], np.geomspace(0.02, 5000.0, 14)])  # variance over the noise's


def log_likelihoods_of_textures(
    pixels: Floats, variance: float, enough: float = math.inf
) -> Iterator[float]:
    """
    Yield the likelihood of pixels that are a random texture and noise, by its correlation.

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
    enough : float
        Where one is as likely as that, how much likelier it is need not be known.

    """
    height, width = pixels.shape
    for smooth, lengths in ((True, SMOOTH), (False, ROUGH)):
        for length in lengths:
            yield -0.5 * _least_deviance(
                pixels, *_modes(height, length, smooth), *_modes(width, length, smooth), variance,
                -2.0 * enough,
            )


def log_likelihood_of_texture(pixels: Floats, variance: float) -> float:
    """Return that of the likeliest correlation."""
    return max(log_likelihoods_of_textures(pixels, variance))


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
    least = math.inf
    for strength in STRENGTHS:
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


@functools.cache
def _modes(count: int, length: float, smooth: bool) -> tuple[Floats, Floats]:
    """Return the eigenvectors and eigenvalues of the correlation along one axis."""
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) / length
    correlation = np.exp(-(distance**2) / 2.0) if smooth else np.exp(-distance)
    values, vectors = np.linalg.eigh(correlation)
    return np.ascontiguousarray(vectors), np.maximum(values, 0.0)

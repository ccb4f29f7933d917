"""How likely the pixels of a window are if what they show is a random texture."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Correlation lengths, px: a lump as small as a pulse, one of some pulses, and edges or slopes.
SMOOTH = (1.0, 2.0, 4.0)  # of exp(-d^2 / 2 l^2)
ROUGH = (3.0, 30.0)  # of exp(-|d| / l) along x times the same along y
STRENGTHS = np.concatenate([[0.0], np.geomspace(0.02, 5000.0, 14)])  # variance over the noise's


def log_likelihood_of_texture(pixels: Floats, variance: float) -> float:
    """
    Return the likelihood of pixels that are a random texture and noise, as likely as can be.

    The texture is a Gaussian process of the mean of the pixels, whose covariance is a product
    of one along x and one along y, K = K_y (x) K_x with the eigenvalues k_i k_j. In the basis
    of the eigenvectors the pixels c_ij are independent (Rasmussen and Williams, Gaussian
    Processes for Machine Learning (2006), eq. 2.30 and 5.8):

        -2 ln L = sum_ij c_ij^2 / (V + S k_i k_j) + ln(V + S k_i k_j)

    The strength S and the correlation are the likeliest of those above.

    Parameters
    ----------
    pixels : (h, w) array
        DN.
    variance : float
        V, of a pixel's noise, DN^2.

    """
    centred = pixels - pixels.mean()
    height, width = pixels.shape
    best = np.inf
    for smooth, lengths in ((True, SMOOTH), (False, ROUGH)):
        for length in lengths:
            down, rows = _modes(height, length, smooth)
            across, columns = _modes(width, length, smooth)
            squares = (down.T @ centred @ across) ** 2
            spread = np.outer(rows, columns)
            total = variance * (1.0 + STRENGTHS[:, None, None] * spread)
            best = min(best, float((squares / total + np.log(total)).sum(axis=(1, 2)).min()))
    return -0.5 * best


@functools.cache
def _modes(count: int, length: float, smooth: bool) -> tuple[Floats, Floats]:
    """Return the eigenvectors and eigenvalues of the correlation along one axis."""
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) / length
    correlation = np.exp(-(distance**2) / 2.0) if smooth else np.exp(-distance)
    values, vectors = np.linalg.eigh(correlation)
    return vectors, np.maximum(values, 0.0)

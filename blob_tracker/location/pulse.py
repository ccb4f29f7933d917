"""The shape of a pulse along one axis: its value in each pixel, and how that value moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Profile = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def integrated_profile(count: int, centre: ArrayLike, sigma: ArrayLike) -> Profile:
    """
    Return the mean of exp(-(k - centre)^2 / 2 sigma^2) over each pixel k, and its derivatives.

    With the pixel's edges t = (k -+ 1/2 - centre) / sqrt2 sigma and D its upper less its lower,

        g = sqrt(pi / 2) sigma D erf(t),   dg/dcentre = -D exp(-t^2),
        dg/dsigma = g / sigma - sqrt2 D t exp(-t^2)

    (Smith et al., Nature Methods 7 (2010), eq. 2 to 4, scaled to a unit peak).

    Parameters
    ----------
    count : int
        Pixels in the row.
    centre, sigma : float or (...) array
        px.

    Returns
    -------
    value, by_centre, by_sigma : (..., count) array
        -, 1/px, 1/px.

    """
    import scipy  # no part of a start

    centre = np.asarray(centre, dtype=float)[..., None]
    sigma = np.asarray(sigma, dtype=float)[..., None]
    edge = (np.arange(count + 1) - 0.5 - centre) / (np.sqrt(2.0) * sigma)
    bell = np.exp(-(edge**2))
    value = np.sqrt(np.pi / 2.0) * sigma * np.diff(scipy.special.erf(edge))
    by_sigma = value / sigma - np.sqrt(2.0) * np.diff(edge * bell)
    return value, -np.diff(bell), by_sigma


def sampled_profile(count: int, centre: ArrayLike, sigma: ArrayLike) -> Profile:
    """
    Return exp(-(k - centre)^2 / 2 sigma^2) at the centre of each pixel k, and its derivatives.

    The thesis samples its pulses so (eq. 4.1, with s = sqrt2 sigma).

    Parameters
    ----------
    count : int
        Pixels in the row.
    centre, sigma : float or (...) array
        px.

    Returns
    -------
    value, by_centre, by_sigma : (..., count) array
        -, 1/px, 1/px.

    """
    centre = np.asarray(centre, dtype=float)[..., None]
    sigma = np.asarray(sigma, dtype=float)[..., None]
    offset = (np.arange(count) - centre) / sigma
    value = np.exp(-0.5 * offset**2)
    return value, value * offset / sigma, value * offset**2 / sigma

"""Light on the sensor: the mean signal of each pixel, before any noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special, 20 MB, when it is first used

REACH = 6.0  # sigma: beyond it the pulse is below 1e-7 of its peak


def pixel_integrated_gaussian(
    shape: tuple[int, int],
    x: float,
    y: float,
    sigma_x: float,
    sigma_y: float | None = None,
) -> NDArray[np.float64]:
    """
    Return the mean of exp(-dx^2 / 2 sigma_x^2 - dy^2 / 2 sigma_y^2) over each pixel.

    The mean over the pixel k is separable into two factors

        sqrt(pi / 2) sigma [erf((k + 1/2 - x) / sqrt2 sigma) - erf((k - 1/2 - x) / sqrt2 sigma)]

    (Smith et al., Nature Methods 7 (2010), eq. 2, times 2 pi sigma_x sigma_y).

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    x, y : float
        Centre, px; the first pixel's centre is (0, 0).
    sigma_x, sigma_y : float
        Standard deviations, px; sigma_y is sigma_x where it is left out.

    Returns
    -------
    (h, w) array
        Times the peak amplitude in DN it is the pulse's mean signal in DN.

    """
    height, width = shape
    along_x = _mean_over_pixels(width, x, sigma_x)
    along_y = _mean_over_pixels(height, y, sigma_x if sigma_y is None else sigma_y)
    return along_y[:, None] * along_x[None, :]


def add_pulse(
    picture: NDArray[np.float32], x: float, y: float, sigma: float, amplitude: float
) -> None:
    """
    Add a round pulse to a picture; what lies beyond its border is cut off.

    Parameters
    ----------
    picture : (h, w) array
        Mean signal, DN; written to.
    x, y : float
        Centre, px.
    sigma : float
        Standard deviation, px.
    amplitude : float
        Peak, DN.

    """
    half = int(np.ceil(REACH * sigma))
    column, row = round(x), round(y)
    left, top = max(column - half, 0), max(row - half, 0)
    # A stop below 0 would count from the far border.
    bottom, right = max(row + half + 1, 0), max(column + half + 1, 0)
    part = picture[top:bottom, left:right]
    if part.size:
        part += amplitude * pixel_integrated_gaussian(
            (part.shape[0], part.shape[1]), x - left, y - top, sigma
        ).astype(np.float32)


def _mean_over_pixels(count: int, centre: float, sigma: float) -> NDArray[np.float64]:
    """Return the mean of a unit Gaussian over each of `count` pixels in a row."""
    edges = np.arange(count + 1) - 0.5 - centre
    return np.sqrt(np.pi / 2) * sigma * np.diff(scipy.special.erf(edges / (np.sqrt(2) * sigma)))

"""Light on the sensor: the mean signal of each pixel, before any noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special, 20 MB, when it is first used

REACH_SIGMA = 6.0  # sigma: beyond it the pulse is below 1e-7 of its peak
# Nodes over a pixel: exact to 1e-7 down to a sigma of 0.4 px.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)

Place = float | NDArray[np.float64]


def pixel_integrated_gaussian(
    shape: tuple[int, int],
    x: Place,
    y: Place,
    sigma_x: float,
    sigma_y: float | None = None,
    *,
    aperture: float = 1.0,
) -> NDArray[np.float64]:
    """
    Return the mean of exp(-dx^2 / 2 sigma_x^2 - dy^2 / 2 sigma_y^2) over each pixel.

    The mean over the pixel k of the aperture a is separable into two factors

        sqrt(pi / 2) sigma / a
            [erf((k + a/2 - x) / sqrt2 sigma) - erf((k - a/2 - x) / sqrt2 sigma)]

    (Smith et al., Nature Methods 7 (2010), eq. 2, times 2 pi sigma_x sigma_y, with a = 1).

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    x, y : float or (h,) array
        Centre, px; the first pixel's centre is (0, 0). An array has the centre that each row
        sees, as with a rolling shutter.
    sigma_x, sigma_y : float
        Standard deviations, px; sigma_y is sigma_x where it is left out.
    aperture : float
        Side of the light-sensitive middle of a pixel, px: the root of the fill factor. 0 takes
        the pulse at the pixels' centres, as the thesis does.

    Returns
    -------
    (h, w) array
        Times the peak amplitude in DN it is the pulse's mean signal in DN.

    Examples
    --------
    A narrow pulse is lower on the mean of its brightest pixel than at its peak:

    >>> pixels = pixel_integrated_gaussian((9, 9), 4.0, 4.0, 0.8)
    >>> round(float(pixels.max()), 2), round(float(pixels.sum() / (2.0 * np.pi * 0.8**2)), 2)
    (0.88, 1.0)

    """
    height, width = shape
    along_x = _mean_over_pixels(width, np.reshape(x, (-1, 1)), sigma_x, aperture)
    along_y = _mean_over_pixels(height, y, sigma_x if sigma_y is None else sigma_y, aperture)
    return along_y[:, None] * along_x


def rotated_gaussian(
    shape: tuple[int, int],
    x: Place,
    y: Place,
    sigma_along: float,
    sigma_across: float,
    angle: float,
    *,
    aperture: float = 1.0,
) -> NDArray[np.float64]:
    """
    Return the mean over each pixel of a Gaussian whose long axis has any direction.

    With the variances a and b of x and y and their covariance c, a row at the distance v has

        exp(-v^2 / 2 b) exp(-(u - v c / b)^2 / 2 (a - c^2 / b))

    whose integral along the row is that of `pixel_integrated_gaussian`; down the pixel it is
    summed by Gauss and Legendre.

    Parameters
    ----------
    shape, x, y, aperture
        See `pixel_integrated_gaussian`.
    sigma_along, sigma_across : float
        Standard deviations along and across the axis, px.
    angle : float
        Of the axis, from x towards y, rad.

    Returns
    -------
    (h, w) array
        Of a peak of 1.

    """
    height, width = shape
    cosine, sine = np.cos(angle), np.sin(angle)
    variance_x = (sigma_along * cosine) ** 2 + (sigma_across * sine) ** 2
    variance_y = (sigma_along * sine) ** 2 + (sigma_across * cosine) ** 2
    shear = (sigma_along**2 - sigma_across**2) * sine * cosine / variance_y
    sigma = np.sqrt(variance_x - shear**2 * variance_y)
    picture = np.zeros(shape)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        down = np.arange(height) + 0.5 * aperture * node - y
        centre = np.reshape(x + shear * down, (-1, 1))
        row = np.exp(-0.5 * down**2 / variance_y)
        along = _mean_over_pixels(width, centre, float(sigma), aperture)
        picture += 0.5 * weight * row[:, None] * along
    return picture


def _mean_over_pixels(
    count: int, centre: Place, sigma: float, aperture: float
) -> NDArray[np.float64]:
    """Return the mean of a unit Gaussian over each of `count` pixels in a row."""
    pixels = np.arange(count)
    if aperture == 0.0:
        return np.asarray(np.exp(-0.5 * ((pixels - centre) / sigma) ** 2))
    scale = np.sqrt(2) * sigma
    high = scipy.special.erf((pixels + 0.5 * aperture - centre) / scale)
    low = scipy.special.erf((pixels - 0.5 * aperture - centre) / scale)
    return np.asarray(np.sqrt(np.pi / 2) * sigma / aperture * (high - low))

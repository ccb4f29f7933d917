"""Three Gaussians with one mean by the Levenberg-Marquardt algorithm (thesis, 4.39, 4.40)."""

from __future__ import annotations

from blob_tracker.location.estimates import Estimates
from blob_tracker.location.multi_gaussian import (
    jacobian,
    jacobian_1d,
    locate_by_fit,
    start_1d,
    three_gaussians,
    three_gaussians_1d,
    vouch_1d,
)
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
from numpy.typing import ArrayLike, NDArray

SETTLED = 1e-4  # relative, of the squared residuals: a tenth of a standard deviation at most
EVALUATIONS = 100  # a round: most windows end within half of one
ROUNDS = 6
CONVERGED_PX = 2e-4  # px in a round: a twentieth of the bound at a peak SNR of 200


def multi_gaussian_lm(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    elliptical: bool = False,
) -> Estimates:
    r"""
    Locate N blobs by three Gaussians with one mean, fitted by Levenberg-Marquardt.

        r = z - sum_l A_l exp(-((x - mu_x)^2 + (y - mu_y)^2) / s_l^2),    s = sqrt2 sigma

    (thesis, eq. 4.39; 4.40 where it is elliptical) with the step of eq. 4.31 as MINPACK takes
    it, and the analytic Jacobian of `three_gaussians`. z is lit - unlit, or lit less the mean of
    the window's corners; clipped pixels are left out.

    Two of the three may cancel, or one vanish, where one Gaussian is enough; the fit has ended
    when the mean no longer moves, whatever the amplitudes and widths do.

    The covariance is the sandwich of `locate_by_fit`, about the mean: a pulse that is
    integrated over its pixels, and the broadest Gaussian's trade with the background, leave a
    bias that it does not hold.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit may be None.
    noise : SensorNoise
        Gain and read noise.
    saturation : float or None
        DN of a clipped pixel.
    elliptical : bool
        Give each Gaussian a width along x and one along y.

    Returns
    -------
    Estimates
        The amplitude is that of the sum, sigma that of its curvature. Failure TOO_FEW_PIXELS
        where fewer are left than parameters (8, or 11), NO_SIGNAL where the brightest pixel is
        below three standard deviations, OUTSIDE where the mean leaves the window, NOT_CONVERGED
        where the mean does not come to rest.

    """
    return locate_by_fit(lit, unlit, noise, saturation, elliptical, _fit)


def multi_gaussian_lm_1d(values: ArrayLike) -> NDArray[np.float64]:
    """
    Fit three Gaussians with one mean to a row of pixels (thesis, eq. 4.32, 4.34).

    Parameters
    ----------
    values : (n,) array
        Light above the background, DN; seven pixels at least.

    Returns
    -------
    (7,) array
        mu, A (3), sigma (3); px and DN.

    Raises
    ------
    LocationError
        If there are fewer than seven values, none above zero, the fit does not end, or what
        it ends with is no peak in the row.

    """
    import scipy  # no part of a start

    row = np.asarray(values, dtype=float)
    with np.errstate(over='ignore', invalid='ignore'):
        found = scipy.optimize.least_squares(
            lambda theta: three_gaussians_1d(theta, row.size) - row, start_1d(row),
            lambda theta: jacobian_1d(theta, row.size), method='lm', x_scale='jac',
            ftol=SETTLED, xtol=1e-10, max_nfev=ROUNDS * EVALUATIONS,
        )
    if found.status <= 0:
        raise LocationError('the fit of three Gaussians did not settle')
    return vouch_1d(found.x, row.size)


def _fit(
    pixels: NDArray[np.float64],
    usable: NDArray[np.bool_],
    start: NDArray[np.float64],
) -> tuple[NDArray[np.float64], bool]:
    """Return the parameters of least squares, and whether the mean has come to rest."""
    import scipy

    def residuals(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return (three_gaussians(theta, *pixels.shape) - pixels)[usable]

    def slopes(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return jacobian(theta, *pixels.shape)[usable.ravel()]

    # Where one Gaussian is enough, amplitudes and widths wander along a valley without an end,
    # and the mean, which they share, does not: it is the mean that must settle.
    for _ in range(ROUNDS):
        found = scipy.optimize.least_squares(
            residuals, start, slopes, method='lm', x_scale='jac', ftol=SETTLED, xtol=1e-10,
            max_nfev=EVALUATIONS,
        )
        if found.status > 0 or np.abs(found.x[:2] - start[:2]).max() < CONVERGED_PX:
            return found.x, True
        start = found.x
    return start, False

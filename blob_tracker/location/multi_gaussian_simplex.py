"""Three Gaussians with one mean by the Nelder-Mead simplex (thesis, 4.37, 4.38)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from blob_tracker.location.estimates import Estimates
from blob_tracker.location.multi_gaussian import locate_by_fit, three_gaussians
from blob_tracker.types import SensorNoise

STANDARD_ERROR = 1e-4  # DN^2: a hundredth of a standard deviation of quantisation alone
EVALUATIONS = 6000


def multi_gaussian_simplex(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    elliptical: bool = False,
) -> Estimates:
    r"""
    Locate N blobs by three Gaussians with one mean, fitted by the Nelder-Mead simplex.

        s(theta) = sum_ij (z_ij - f_ij(theta))^2                       (thesis, eq. 4.37, 4.38)

    with f of `three_gaussians`. It ends when the standard error of the values at the simplex'
    corners, sqrt(sum (s - mean s)^2 / n), is small (thesis, section 4.3), whatever the
    simplex' size: when their range is, which holds the standard error below it.

    The rest is as in `multi_gaussian_lm`, which finds the same minimum a hundred times faster.

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
        As in `multi_gaussian_lm`.

    """
    return locate_by_fit(lit, unlit, noise, saturation, elliptical, _fit)


def _fit(
    pixels: NDArray[np.float64],
    usable: NDArray[np.bool_],
    start: NDArray[np.float64],
    elliptical: bool,
) -> tuple[NDArray[np.float64], bool]:
    """Return the parameters of least squares, and whether the simplex came to rest."""

    def squared_error(theta: NDArray[np.float64]) -> float:
        residual = (three_gaussians(theta, pixels.shape, elliptical) - pixels)[usable]
        return float(residual @ residual)

    # Corners half a pixel, and a tenth of each amplitude and width, off the start.
    corners = np.tile(start, (start.size + 1, 1))
    corners[np.arange(start.size) + 1, np.arange(start.size)] += np.concatenate(
        [[0.5, 0.5], 0.1 * start[2:]]
    )
    found = minimize(
        squared_error, start, method='Nelder-Mead',
        options={
            'initial_simplex': corners, 'adaptive': True, 'xatol': np.inf,
            'fatol': STANDARD_ERROR, 'maxfev': EVALUATIONS, 'maxiter': EVALUATIONS,
        },
    )
    return found.x, bool(found.success)

"""Three Gaussians with one mean by the Nelder-Mead simplex (thesis, 4.37, 4.38)."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.multi_gaussian import (
    locate_by_fit,
    start_1d,
    three_gaussians,
    three_gaussians_1d,
    vouch_1d,
)
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
from numpy.typing import ArrayLike, NDArray

STANDARD_ERROR_DN2 = 1e-3  # DN^2: what a tenth of the standard deviation of rounding changes
EVALUATIONS = 1500  # a round
ROUNDS = 5
CONVERGED_PX = 1e-3  # px in a round


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
    simplex' size: when their range is, which holds the standard error below it. It also ends
    when a simplex that is built anew about the best point leaves the mean where it was.

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


def multi_gaussian_simplex_1d(values: ArrayLike) -> NDArray[np.float64]:
    """
    Fit three Gaussians with one mean to a row of pixels (thesis, eq. 4.32, 4.33).

    Parameters, result and errors are those of `multi_gaussian_lm_1d`.
    """
    row = np.asarray(values, dtype=float)

    def squared_error(theta: NDArray[np.float64]) -> float:
        residual = three_gaussians_1d(theta, row.size) - row
        return float(residual @ residual)

    start = start_1d(row)
    edge = np.concatenate([[0.5], 0.1 * start[1:]])
    best, at_rest = _descend(squared_error, start, edge, ROUNDS * EVALUATIONS)
    if not at_rest:
        raise LocationError('the fit of three Gaussians did not settle')
    return vouch_1d(best, row.size)


def _fit(
    pixels: NDArray[np.float64],
    usable: NDArray[np.bool_],
    start: NDArray[np.float64],
) -> tuple[NDArray[np.float64], bool]:
    """Return the parameters of least squares, and whether the simplex or its mean came to rest."""

    def squared_error(theta: NDArray[np.float64]) -> float:
        return _squared_error(theta, pixels, usable)

    # A simplex creeps along the valley where one Gaussian is enough; a new one about its best
    # shows whether the mean, which the three share, still moves.
    for _ in range(ROUNDS):
        edge = np.concatenate([[0.5, 0.5], 0.1 * start[2:]])
        best, at_rest = _descend(squared_error, start, edge)
        if at_rest or np.abs(best[:2] - start[:2]).max() < CONVERGED_PX:
            return best, True
        start = best
    return start, False


@kernel
def _squared_error(theta: Array, pixels: Array, usable: NDArray[np.bool_]) -> float:
    """Return the sum of the squared residuals of the usable pixels."""
    model = three_gaussians(theta, pixels.shape[0], pixels.shape[1])
    total = 0.0
    for j in range(pixels.shape[0]):
        for i in range(pixels.shape[1]):
            if usable[j, i]:
                total += (model[j, i] - pixels[j, i]) ** 2
    return total


def _descend(
    squared_error: Callable[[NDArray[np.float64]], float],
    start: NDArray[np.float64],
    edge: NDArray[np.float64],
    evaluations: int = EVALUATIONS,
) -> tuple[NDArray[np.float64], bool]:
    """Run the simplex from corners an edge off the start; return its best, and if it rests."""
    import scipy  # no part of a start

    corners = np.tile(start, (start.size + 1, 1))
    corners[1:] += np.diag(edge)
    with np.errstate(over='ignore', invalid='ignore'):
        found = scipy.optimize.minimize(
            squared_error, start, method='Nelder-Mead',
            options={
                'initial_simplex': corners, 'adaptive': True, 'xatol': np.inf,
                'fatol': STANDARD_ERROR_DN2, 'maxfev': evaluations, 'maxiter': evaluations,
            },
        )
    return found.x, bool(found.success)

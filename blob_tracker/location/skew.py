"""The centroid's skew error in closed form, and the centroid with it taken out."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.likelihood import empty_profiles, fill_profile, Profiles
from blob_tracker.location.moments import misfit, Moments, moments
from blob_tracker.location.normal_equations import empty_equations, NormalEquations, solve
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.location.signal import corner_weights, count_clipped
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import ArrayLike, NDArray

STEPS = 30
CONVERGED_PX = 1e-7  # px
DIFFERENCE_STEP_PX = 1e-5  # px: the step of the Jacobian's differences
NARROWEST_PX = 0.2  # px: narrower, the moments are those of one pixel
WIDEST = 0.5  # times the window: beyond it the moments are the window's, not the pulse's

_NONE = int(Failure.NONE)


def skew_error(
    count: int, centre: ArrayLike, sigma: ArrayLike, *, sampled: bool = False
) -> NDArray[np.float64]:
    r"""
    Return the centroid's error for a noise-free Gaussian that the window cuts unevenly.

        epsilon = sum_k (k - centre) g_k / sum_k g_k,     k = 0 ... count - 1

    With k counted from the pixel nearest the centre and g sampled this is eq. 3.27 of the thesis
    for a window of 2n pixels and a displacement above zero, A.9 for one below, and A.17 for
    2n + 1 pixels. (The thesis pairs the terms of either side; the lower limit of the sums
    printed in A.9 and A.17 is 1, where A.8 and A.16, from which they follow, have 0.) It does not
    depend on the other axis (eq. 3.35).

    Parameters
    ----------
    count : int
        Pixels along the axis.
    centre, sigma : float or (...) arrays
        True centre and standard deviation (the thesis' s over sqrt2), px.
    sampled : bool
        The pulse is sampled at the pixels' centres (as in the thesis), not integrated over them.

    Returns
    -------
    (...) array
        Centroid less truth, px.

    """
    profile = sampled_profile if sampled else integrated_profile
    value = profile(count, centre, sigma)[0]
    distance = np.arange(count) - np.asarray(centre, dtype=float)[..., None]
    return (distance * value).sum(axis=-1) / value.sum(axis=-1)


def centroid_skew_corrected(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
) -> Estimates:
    r"""
    Locate N blobs by the centroid, less the skew error of the window's edges.

    The centroid and the second moment of the window (as in `centroid`) are those of a cut
    Gaussian. Newton's method finds the (x, y, sigma) whose pixel-integrated Gaussian, cut alike
    and with the mean of its own corners taken off if there is no unlit window, has the same
    three. The correction of x is `skew_error` where the background is known.

    The covariance is that of the three moments, linear in the pixels, carried through the
    inverse of Newton's Jacobian; the amplitude is the signal's sum over that of the unit pulse.
    The estimate has no bias but that of a ratio of noisy sums, of second order in 1 / SNR.

    No pulse has the moments of a window whose second moment the noise has thrown below that of
    a pixel or near that of the window itself, as it does with every other one at a peak SNR of
    3. What is known then is the plain centroid, and that the skew is at most that of the widest
    pulse that is taken, d: the answer is the centroid, with d d^T / 3 added to its covariance
    (an error that is even between none and d).

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit may be None.
    noise : SensorNoise
        Gain and read noise.
    saturation : float or None
        DN of a clipped pixel. Clipped pixels are counted and used as they are.

    Returns
    -------
    Estimates
        Failure NO_SIGNAL as in `centroid`, OUTSIDE where the position leaves the window.

    """
    found = moments(lit, unlit, noise)
    failure = found.failure.copy()
    # x, y, amplitude, level, sigma, SNR, chi2.
    table = np.zeros((7, lit.shape[0]))
    covariance = np.zeros((lit.shape[0], 2, 2))
    _invert_all(
        lit, lit[:0] if unlit is None else unlit, 1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0, corner_weights(lit.shape[1], lit.shape[2]), found,
        table, covariance,
    )
    failure = outside(table[0], table[1], lit.shape, failure)
    return Estimates.from_table(table, covariance, count_clipped(lit, saturation), failure)


@kernel
def _invert_all(
    lit: Array,
    unlit: Array,
    shot: float,
    floor: float,
    corners: Array,
    found: Moments,
    table: Array,
    covariance: Array,
) -> None:
    """Fill the table and the covariances from the moments."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    profiles = empty_profiles(height, width)
    equations = empty_equations()
    theta = np.empty(3)
    value = np.empty(3)
    shifted = np.empty(3)
    jacobian = np.empty((3, 3))
    widest = WIDEST * max(height, width)
    for n in range(count):
        if found.failure[n] != _NONE:
            continue
        target = found.value[n]
        theta[0] = min(max(target[0], 0.0), width - 1.0)
        theta[1] = min(max(target[1], 0.0), height - 1.0)
        theta[2] = min(max(math.sqrt(max(target[2], 0.25)), 0.5), max(height, width) / 4.0)
        converged = False
        for _ in range(STEPS):
            if not _cut_moments(theta, profiles, corners, paired, value):
                break
            for p in range(3):
                theta[p] += DIFFERENCE_STEP_PX
                _cut_moments(theta, profiles, corners, paired, shifted)
                theta[p] -= DIFFERENCE_STEP_PX
                for q in range(3):
                    jacobian[q, p] = (shifted[q] - value[q]) / DIFFERENCE_STEP_PX
            if not _newton(jacobian, target, value, equations):
                break
            longest_step = 0.0
            for p in range(3):
                step = min(max(equations.solution[p], -0.5), 0.5)
                longest_step = max(longest_step, abs(step))
                theta[p] += step
            theta[2] = min(max(theta[2], 0.5 * NARROWEST_PX), 1.2 * widest)
            if longest_step < CONVERGED_PX:
                converged = True
                break
        converged = converged and NARROWEST_PX < theta[2] < widest
        converged = converged and -0.5 <= theta[0] <= width - 0.5
        converged = converged and -0.5 <= theta[1] <= height - 0.5
        if converged:
            _propagate_covariance(jacobian, found.covariance[n], covariance[n])
        else:
            # The centroid, with the skew of the widest pulse as its uncertainty.
            middle_x, middle_y = 0.5 * (width - 1), 0.5 * (height - 1)
            theta[0], theta[1], theta[2] = middle_x + 0.25, middle_y + 0.25, widest
            _cut_moments(theta, profiles, corners, paired, value)
            skew_x = (target[0] - middle_x) * (0.25 / max(value[0] - middle_x, 0.05) - 1.0)
            skew_y = (target[1] - middle_y) * (0.25 / max(value[1] - middle_y, 0.05) - 1.0)
            theta[0], theta[1] = target[0], target[1]
            theta[2] = min(max(math.sqrt(max(target[2], 0.0)), NARROWEST_PX), widest)
            covariance[n] = found.covariance[n, :2, :2]
            covariance[n, 0, 0] += skew_x**2 / 3.0
            covariance[n, 0, 1] += skew_x * skew_y / 3.0
            covariance[n, 1, 0] += skew_x * skew_y / 3.0
            covariance[n, 1, 1] += skew_y**2 / 3.0
        fill_profile(theta[0], theta[2], profiles.across)
        fill_profile(theta[1], theta[2], profiles.down)
        tail = 0.0 if paired else _tail(profiles, corners)
        unit = profiles.across[0].sum() * profiles.down[0].sum() - height * width * tail
        amplitude = found.total[n] / max(unit, 0.5)
        table[0, n], table[1, n] = theta[0], theta[1]
        table[2, n] = amplitude
        table[3, n] = found.background[n] - amplitude * tail
        table[4, n] = theta[2]
        table[5, n], table[6, n] = misfit(
            lit, unlit, n, shot, floor, amplitude, table[3, n], profiles
        )


@kernel
def _cut_moments(
    theta: Array, profiles: Profiles, corners: Array, paired: bool, value: Array
) -> bool:
    """Fill value with the moments of the pulse that the window cuts; False where it has none."""
    fill_profile(theta[0], theta[2], profiles.across)
    fill_profile(theta[1], theta[2], profiles.down)
    tail = 0.0 if paired else _tail(profiles, corners)
    width, height = profiles.across.shape[1], profiles.down.shape[1]
    x0, x1, x2 = _powers(profiles.across[0])
    y0, y1, y2 = _powers(profiles.down[0])
    total = x0 * y0 - tail * width * height
    if not total > 1e-6 * x0 * y0:
        return False
    # The sums of k and of k^2 over a row are n (n - 1) / 2 and n (n - 1) (2 n - 1) / 6.
    x1 = (x1 * y0 - tail * height * width * (width - 1) / 2.0) / total
    y1 = (y1 * x0 - tail * width * height * (height - 1) / 2.0) / total
    x2 = (x2 * y0 - tail * height * width * (width - 1) * (2 * width - 1) / 6.0) / total
    y2 = (y2 * x0 - tail * width * height * (height - 1) * (2 * height - 1) / 6.0) / total
    value[0], value[1] = x1, y1
    value[2] = 0.5 * (x2 - x1 * x1 + y2 - y1 * y1)
    return True


@kernel
def _powers(row: Array) -> tuple[float, float, float]:
    """Return the sums of g, k g and k^2 g over a row."""
    first, second, third = 0.0, 0.0, 0.0
    for k in range(row.size):
        first += row[k]
        second += k * row[k]
        third += k * k * row[k]
    return first, second, third


@kernel
def _tail(profiles: Profiles, corners: Array) -> float:
    """Return what the unit pulse adds to the background that is taken from the corners."""
    tail = 0.0
    for j in range(corners.shape[0]):
        for i in range(corners.shape[1]):
            tail += corners[j, i] * profiles.down[0, j] * profiles.across[0, i]
    return tail


@kernel
def _newton(
    jacobian: Array, target: Array, value: Array, equations: NormalEquations
) -> bool:
    """Solve J step = target - value; False where J is singular."""
    for p in range(3):
        equations.right[p] = 0.0
        for k in range(3):
            equations.right[p] += jacobian[k, p] * (target[k] - value[k])
        for q in range(p + 1):
            equations.matrix[p, q] = 0.0
            for k in range(3):
                equations.matrix[p, q] += jacobian[k, p] * jacobian[k, q]
    return solve(equations, 3, 0.0)


@kernel
def _propagate_covariance(jacobian: Array, moments_covariance: Array, covariance: Array) -> None:
    """Fill covariance with that of x and y: J^-1 C J^-T."""
    inverse = np.linalg.inv(jacobian)
    for p in range(2):
        for q in range(2):
            covariance[p, q] = 0.0
            for k in range(3):
                for m in range(3):
                    covariance[p, q] += inverse[p, k] * moments_covariance[k, m] * inverse[q, m]

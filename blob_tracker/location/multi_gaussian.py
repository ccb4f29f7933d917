"""Three Gaussians with one mean: the model, its start value and its Jacobian (thesis, 4.3)."""

from __future__ import annotations

from collections.abc import Callable
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.signal import count_clipped, signal_above_background
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
from numpy.typing import NDArray

# The lamp of the thesis' camera (section 4.3.2, eq. 4.35): peaks, DN, and s over the least s.
LAMP_AMPLITUDES = (154.25, 77.68, 22.07)
LAMP_WIDTHS = (1.0, 2.57, 4.97)
# Of a peak of 1 and in standard deviations: the blob from which each fit starts.
AMPLITUDES = np.array(LAMP_AMPLITUDES) / sum(LAMP_AMPLITUDES)
WIDTHS = np.array(LAMP_WIDTHS) / math.sqrt(2.0)
HALF_AREA = 4.15  # s^2 of the first Gaussian: the area where that blob is above half its peak
FAINTEST_SIGMA = 3.0  # standard deviations of the brightest pixel
NARROWEST_PX = 0.5  # px: a narrower Gaussian is one pixel's, and a fit gives it that pixel's noise
FARTHEST = 1e7  # px or DN: two amplitudes that cancel beyond it leave no digits

Fit = Callable[
    [NDArray[np.float64], NDArray[np.bool_], NDArray[np.float64]],
    tuple[NDArray[np.float64], bool],
]


@kernel
def three_gaussians(theta: Array, height: int, width: int) -> Array:
    r"""
    Return the sum of three sampled Gaussians with one mean (thesis, eq. 4.35, 4.36).

        f = sum_l A_l exp(-(x - mu_x)^2 / 2 sigma_xl^2 - (y - mu_y)^2 / 2 sigma_yl^2)

    (The square that eq. 4.35 and 4.37 print about the whole exponent is not in eq. 4.39.)

    Parameters
    ----------
    theta : (8,) or (11,) array
        mu_x, mu_y, A (3), sigma (3), and where it is elliptical sigma_y (3); px and DN.
    height, width : int
        px.

    Returns
    -------
    (h, w) array
        DN.

    """
    model = np.zeros((height, width))
    for pulse in range(3):
        across = _row(theta[0], theta[5 + pulse], width)
        down = _row(theta[1], theta[theta.size - 3 + pulse], height)
        for j in range(height):
            for i in range(width):
                model[j, i] += theta[2 + pulse] * down[0, j] * across[0, i]
    return model


@kernel
def jacobian(theta: Array, height: int, width: int) -> Array:
    """Return the (h w, P) derivatives of `three_gaussians` by its parameters."""
    slopes = np.zeros((height * width, theta.size))
    for pulse in range(3):
        across = _row(theta[0], theta[5 + pulse], width)
        down = _row(theta[1], theta[theta.size - 3 + pulse], height)
        peak = theta[2 + pulse]
        for j in range(height):
            for i in range(width):
                row = slopes[j * width + i]
                row[0] += peak * down[0, j] * across[1, i]
                row[1] += peak * down[1, j] * across[0, i]
                row[2 + pulse] = down[0, j] * across[0, i]
                row[5 + pulse] += peak * down[0, j] * across[2, i]
                row[theta.size - 3 + pulse] += peak * down[2, j] * across[0, i]
    return slopes


@kernel
def _row(centre: float, sigma: float, count: int) -> Array:
    """Return `sampled_profile` of one Gaussian: value, by centre, by sigma, each (count,)."""
    # The sign of a width means nothing; its slope keeps it.
    sigma = math.copysign(max(abs(sigma), NARROWEST_PX), sigma)
    profile = np.empty((3, count))
    for k in range(count):
        offset = (k - centre) / sigma
        value = math.exp(-0.5 * offset * offset)
        profile[0, k] = value
        profile[1, k] = value * offset / sigma
        profile[2, k] = value * offset * offset / sigma
    return profile


@kernel
def three_gaussians_1d(theta: Array, count: int) -> Array:
    r"""
    Return f(k) = sum_l A_l exp(-(k - mu)^2 / 2 sigma_l^2), k = 0 ... count - 1 (thesis, eq. 4.32).

    Parameters
    ----------
    theta : (7,) array
        mu, A (3), sigma (3); px and DN.
    count : int
        Pixels in the row.

    Returns
    -------
    (count,) array
        DN.

    """
    model = np.zeros(count)
    for pulse in range(3):
        model += theta[1 + pulse] * _row(theta[0], theta[4 + pulse], count)[0]
    return model


@kernel
def jacobian_1d(theta: Array, count: int) -> Array:
    """Return the (count, 7) derivatives of `three_gaussians_1d` by its parameters."""
    slopes = np.zeros((count, 7))
    for pulse in range(3):
        row = _row(theta[0], theta[4 + pulse], count)
        slopes[:, 0] += theta[1 + pulse] * row[1]
        slopes[:, 1 + pulse] = row[0]
        slopes[:, 4 + pulse] = theta[1 + pulse] * row[2]
    return slopes


def start_1d(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the thesis' blob, scaled to the peak and the half-height width of a row."""
    usable = values.ndim == 1 and values.size >= 7 and np.isfinite(values).all()
    peak = float(values.max()) if usable else 0.0
    if not peak > 0.0:
        raise LocationError('three Gaussians need a row of at least 7 finite pixels with light')
    bright = np.maximum(values - 0.5 * peak, 0.0)
    centre = bright @ np.arange(values.size) / bright.sum()
    # That blob is above half its peak over 2 sqrt(HALF_AREA / pi) s.
    scale = max(int(np.count_nonzero(bright)), 2) / math.sqrt(4.0 * HALF_AREA / math.pi)
    return np.concatenate([[centre], peak * AMPLITUDES, scale * WIDTHS])


def vouch_1d(theta: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return the parameters of a row's fit; raise where they are no pulse in the row."""
    if not np.isfinite(theta).all() or np.abs(theta).max() >= FARTHEST:
        raise LocationError('the fit of three Gaussians did not settle')
    if not -0.5 <= theta[0] <= count - 0.5:
        raise LocationError(f'the mean of the three Gaussians leaves the row: {theta[0]:.1f} px')
    if theta[1:4].sum() <= 0.0:
        raise LocationError('the three Gaussians together have no peak')
    return theta


def locate_by_fit(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    elliptical: bool,
    fit: Fit,
) -> Estimates:
    r"""
    Fit three Gaussians to each window by `fit` and carry the noise to the position.

    The covariance is the sandwich J+ V J+^T with J+ the pseudo-inverse of the Jacobian at the
    solution and V the variance of the pixels: that of unweighted least squares under noise of
    unequal variance. The pseudo-inverse, because three Gaussians seldom determine all of
    their amplitudes and widths, and the position does not depend on how they share the light.
    """
    signal = signal_above_background(lit, unlit, noise)
    count, height, width = lit.shape
    size = 11 if elliptical else 8
    theta = np.zeros((count, size))
    theta[:, 5:] = 1.0
    influence = np.zeros((count, 2, height * width))
    model = np.zeros(lit.shape)
    failure = np.zeros(count, dtype=np.uint8)
    for n in range(count):
        pixels = signal.pixels[n]
        usable = np.ones((height, width), dtype=bool)
        if saturation is not None:
            usable = lit[n] < saturation
        if usable.sum() < size:
            failure[n] = Failure.TOO_FEW_PIXELS
            continue
        brightest = np.unravel_index(np.argmax(pixels), pixels.shape)
        if pixels[brightest] <= FAINTEST_SIGMA * math.sqrt(signal.variance[n][brightest]):
            failure[n] = Failure.NO_SIGNAL
            continue
        # A step too far may overflow; the search turns back by itself or ends without a result.
        with np.errstate(over='ignore', invalid='ignore'):
            found, converged = fit(pixels, usable, _start(pixels, elliptical))
        if converged and np.abs(found).max() < FARTHEST:
            theta[n] = found
        else:
            failure[n] = Failure.NOT_CONVERGED
            continue
        failure[n] = outside(theta[n, :1], theta[n, 1:2], lit.shape, failure[n:n + 1])[0]
        if failure[n] != Failure.NONE:
            continue
        model[n] = three_gaussians(theta[n], height, width)
        slopes = jacobian(theta[n], height, width) * usable.reshape(-1, 1)
        length = np.sqrt((slopes**2).sum(axis=0))
        length[length == 0.0] = 1.0
        inverse = np.linalg.pinv(slopes / length, rcond=1e-9)
        influence[n] = inverse[:2] / length[:2, None]
        if not (influence[n] ** 2).sum(axis=1).all():
            failure[n] = Failure.NOT_CONVERGED
    covariance = signal.spread(influence.reshape(count, 2, height, width))
    amplitude = theta[:, 2:5].sum(axis=1)
    # A spike or a pit between the pixels, which the pixels do not see, is no peak to speak of.
    failure[(amplitude <= 0.0) & (failure == Failure.NONE)] = Failure.NOT_CONVERGED
    sigma = _equivalent_sigma(theta, elliptical)
    snr, chi2 = signal.quality(amplitude, model, size, noise)
    return Estimates(
        x=theta[:, 0],
        y=theta[:, 1],
        covariance=covariance,
        amplitude=amplitude,
        background=signal.background,
        sigma=sigma,
        snr=snr,
        chi2=chi2,
        saturated=count_clipped(lit, saturation),
        failure=failure,
    )


def _start(pixels: NDArray[np.float64], elliptical: bool) -> NDArray[np.float64]:
    """Return the thesis' blob, scaled to the peak and the half-height area of the pixels."""
    peak = float(pixels.max())
    bright = np.where(pixels > 0.5 * peak, pixels - 0.5 * peak, 0.0)
    total = bright.sum()
    x = float(bright.sum(axis=0) @ np.arange(pixels.shape[1]) / total)
    y = float(bright.sum(axis=1) @ np.arange(pixels.shape[0]) / total)
    scale = math.sqrt(max(int(np.count_nonzero(bright)), 2) / HALF_AREA)
    widths = scale * WIDTHS
    return np.concatenate([[x, y], peak * AMPLITUDES, widths, widths if elliptical else []])


def _equivalent_sigma(
    theta: NDArray[np.float64], elliptical: bool
) -> NDArray[np.float64]:
    """
    Return the sigma of the one Gaussian that falls from its peak as the sum does.

    The curvature at the peak over the peak: 1 / sigma^2 = sum A_l / sigma_l^2 / sum A_l.
    """
    across = np.maximum(np.abs(theta[:, 5:8]), NARROWEST_PX)
    down = np.maximum(np.abs(theta[:, 8:11]), NARROWEST_PX) if elliptical else across
    steep = (theta[:, 2:5] / (across * down)).sum(axis=1)
    total = theta[:, 2:5].sum(axis=1)
    plain = (steep > 0.0) & (total > 0.0)
    return np.sqrt(np.where(plain, total, 1.0) / np.where(plain, steep, 1.0))

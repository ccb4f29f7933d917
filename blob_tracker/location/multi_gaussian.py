"""Three Gaussians with one mean: the model, its start value and its Jacobian (thesis, 4.3)."""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np
from numpy.typing import NDArray

from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.pulse import sampled_profile
from blob_tracker.location.signal import count_clipped, signal_above_background
from blob_tracker.types import SensorNoise

# The blob of the thesis' camera (section 4.3.2), from which each fit starts.
AMPLITUDES = np.array([154.25, 77.68, 22.07]) / 254.0
WIDTHS = np.array([1.0, 2.57, 4.97]) / math.sqrt(2.0)
HALF_AREA = 4.15  # s^2 of the first Gaussian: the area where that blob is above half its peak
FAINTEST = 3.0  # standard deviations of the brightest pixel

Fit = Callable[[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], bool],
               tuple[NDArray[np.float64], bool]]


def profiles(
    theta: NDArray[np.float64], shape: tuple[int, int], elliptical: bool
) -> tuple[tuple[NDArray[np.float64], ...], tuple[NDArray[np.float64], ...]]:
    """Return the (3, w) and (3, h) profiles of the three Gaussians and their derivatives."""
    across = theta[5:8]
    down = theta[8:11] if elliptical else across
    return (
        sampled_profile(shape[1], np.full(3, theta[0]), across),
        sampled_profile(shape[0], np.full(3, theta[1]), down),
    )


def three_gaussians(
    theta: NDArray[np.float64], shape: tuple[int, int], elliptical: bool
) -> NDArray[np.float64]:
    r"""
    Return the sum of three sampled Gaussians with one mean (thesis, eq. 4.35, 4.36).

        f = sum_l A_l exp(-(x - mu_x)^2 / 2 sigma_xl^2 - (y - mu_y)^2 / 2 sigma_yl^2)

    (The square that eq. 4.35 and 4.37 print about the whole exponent is not in eq. 4.39.)

    Parameters
    ----------
    theta : (8,) or (11,) array
        mu_x, mu_y, A (3), sigma (3), and where it is elliptical sigma_y (3); px and DN.
    shape : (int, int)
        Height and width, px.
    elliptical : bool
        There are widths along y of their own.

    Returns
    -------
    (h, w) array
        DN.

    """
    (across, *_), (down, *_) = profiles(theta, shape, elliptical)
    return (theta[2:5, None] * down).T @ across


def jacobian(
    theta: NDArray[np.float64], shape: tuple[int, int], elliptical: bool
) -> NDArray[np.float64]:
    """Return the (h w, P) derivatives of `three_gaussians` by its parameters."""
    (g, gx, gs), (h, hy, hs) = profiles(theta, shape, elliptical)
    peak = theta[2:5, None]
    unit = h[:, :, None] * g[:, None, :]
    wider = (peak * h)[:, :, None] * gs[:, None, :]
    taller = (peak * hs)[:, :, None] * g[:, None, :]
    position = [((peak * h).T @ gx)[None], ((peak * hy).T @ g)[None]]
    widths = [wider, taller] if elliptical else [wider + taller]
    return np.concatenate([*position, unit, *widths]).reshape(theta.size, -1).T


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
        if pixels[brightest] <= FAINTEST * math.sqrt(signal.variance[n][brightest]):
            failure[n] = Failure.NO_SIGNAL
            continue
        theta[n], converged = fit(pixels, usable, _start(pixels, elliptical), elliptical)
        if not converged or not np.isfinite(theta[n]).all():
            failure[n] = Failure.NOT_CONVERGED
            continue
        failure[n] = outside(theta[n, :1], theta[n, 1:2], lit.shape, failure[n:n + 1])[0]
        if failure[n] != Failure.NONE:
            continue
        model[n] = three_gaussians(theta[n], (height, width), elliptical)
        slopes = jacobian(theta[n], (height, width), elliptical) * usable.reshape(-1, 1)
        length = np.sqrt((slopes**2).sum(axis=0))
        length[length == 0.0] = 1.0
        inverse = np.linalg.pinv(slopes / length, rcond=1e-9)
        influence[n] = inverse[:2] / length[:2, None]
        if not (influence[n] ** 2).sum(axis=1).all():
            failure[n] = Failure.NOT_CONVERGED
    covariance = signal.spread(influence.reshape(count, 2, height, width))
    amplitude = theta[:, 2:5].sum(axis=1)
    failure[(amplitude <= 0.0) & (failure == Failure.NONE)] = Failure.NO_SIGNAL
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
    peak = pixels.max()
    bright = np.where(pixels > 0.5 * peak, pixels - 0.5 * peak, 0.0)
    total = bright.sum()
    x = float(bright.sum(axis=0) @ np.arange(pixels.shape[1]) / total)
    y = float(bright.sum(axis=1) @ np.arange(pixels.shape[0]) / total)
    scale = math.sqrt(max(np.count_nonzero(bright), 2) / HALF_AREA)
    widths = scale * WIDTHS
    return np.concatenate([[x, y], peak * AMPLITUDES, widths, widths if elliptical else []])


def _equivalent_sigma(
    theta: NDArray[np.float64], elliptical: bool
) -> NDArray[np.float64]:
    """
    Return the sigma of the one Gaussian that falls from its peak as the sum does.

    The curvature at the peak over the peak: 1 / sigma^2 = sum A_l / sigma_l^2 / sum A_l.
    """
    down = theta[:, 8:11] if elliptical else theta[:, 5:8]
    peaks = theta[:, 2:5]
    steep = (peaks / np.maximum(np.abs(theta[:, 5:8] * down), 1e-6)).sum(axis=1)
    total = peaks.sum(axis=1)
    plain = (steep > 0.0) & (total > 0.0)
    return np.sqrt(np.where(plain, total, 1.0) / np.where(plain, steep, 1.0))

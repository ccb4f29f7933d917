"""The centroid's skew error in closed form, and the centroid with it taken out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from blob_tracker.location.centroid import moments
from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.location.signal import count_clipped, signal_above_background
from blob_tracker.types import SensorNoise

STEPS = 30
SETTLED = 1e-7  # px
WIDEST = 0.5  # times the window: beyond it the moments are the window's, not the pulse's


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
    and with the mean of its own border taken off where there is no unlit window, has the same
    three. The correction of x is `skew_error` where the background is known.

    The covariance is that of the three moments, linear in the pixels, carried through the
    inverse of Newton's Jacobian; the amplitude is the signal's sum over that of the unit pulse.
    The estimate has no bias but that of a ratio of noisy sums, of second order in 1 / SNR.

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
        Failure NO_SIGNAL as in `centroid`, OUTSIDE where the position leaves the window,
        TOO_WIDE where the second moment is that of the window itself, TOO_NARROW where it is
        that of one pixel, NOT_CONVERGED where no cut Gaussian has these moments.

    """
    signal = signal_above_background(lit, unlit, noise)
    found = moments(signal)
    count, height, width = lit.shape
    dx, dy = found.offsets(signal)
    spread = 0.5 * (dx**2 + dy**2) - found.width[:, None, None]
    shape = (count, height, width)
    influence = np.stack([np.broadcast_to(part, shape) for part in (dx, dy, spread)], axis=1)
    covariance = signal.spread(influence / found.total[:, None, None, None])

    target = np.stack([found.x, found.y, found.width], axis=1)
    middle = np.array([(width - 1) / 2.0, (height - 1) / 2.0])
    theta = np.empty((count, 3))
    theta[:, :2] = np.clip(target[:, :2], 0.0, 2.0 * middle)
    theta[:, 2] = np.sqrt(np.clip(target[:, 2], 0.25, (max(height, width) / 4.0) ** 2))
    lowest = np.array([-1.0, -1.0, 0.15])
    highest = np.array([width, height, 2.0 * WIDEST * max(height, width)])
    settled = np.zeros(count, dtype=bool)
    jacobian = np.tile(np.eye(3), (count, 1, 1))
    unit = np.ones(count)
    for _ in range(STEPS):
        value, unit = _cut_moments(shape, theta, signal.border)
        for p in range(3):
            nearby = theta.copy()
            nearby[:, p] += 1e-5
            jacobian[:, :, p] = (_cut_moments(shape, nearby, signal.border)[0] - value) / 1e-5
        regular = np.abs(np.linalg.det(jacobian)) > 1e-9
        jacobian[~regular] = np.eye(3)
        step = np.linalg.solve(jacobian, (target - value)[:, :, None])[:, :, 0]
        step = np.clip(step, -0.5, 0.5)
        theta = np.clip(theta + step, lowest, highest)
        settled = regular & (np.abs(step).max(axis=1) < SETTLED)
        if (settled | (found.failure != Failure.NONE)).all():
            break
    inverse = np.linalg.inv(jacobian)
    covariance = (inverse @ covariance @ inverse.transpose(0, 2, 1))[:, :2, :2]

    failure = outside(theta[:, 0], theta[:, 1], shape, found.failure)
    fresh = failure == Failure.NONE
    failure[fresh & ~settled] = Failure.NOT_CONVERGED
    failure[fresh & (theta[:, 2] > WIDEST * max(height, width))] = Failure.TOO_WIDE
    failure[fresh & (theta[:, 2] < 0.2)] = Failure.TOO_NARROW
    failure[fresh & (unit <= 0.0)] = Failure.TOO_WIDE
    amplitude = found.total / np.where(unit > 0.0, unit, 1.0)
    pulse = _pulse(shape, theta)
    tail = np.einsum('nhw,hw->n', pulse, signal.border)
    model = amplitude[:, None, None] * (pulse - tail[:, None, None])
    snr, chi2 = signal.quality(amplitude, model, 5, noise)
    return Estimates(
        x=theta[:, 0],
        y=theta[:, 1],
        covariance=covariance,
        amplitude=amplitude,
        background=signal.background - amplitude * tail,
        sigma=theta[:, 2],
        snr=snr,
        chi2=chi2,
        saturated=count_clipped(lit, saturation),
        failure=failure,
    )


def _pulse(shape: tuple[int, int, int], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (N, h, w) unit pulses of the (N, 3) parameters x, y, sigma."""
    across = integrated_profile(shape[2], theta[:, 0], theta[:, 2])[0]
    down = integrated_profile(shape[1], theta[:, 1], theta[:, 2])[0]
    return down[:, :, None] * across[:, None, :]


def _cut_moments(
    shape: tuple[int, int, int], theta: NDArray[np.float64], border: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return centroid and second moment (N, 3) of unit pulses cut by the window; their sum."""
    pulse = _pulse(shape, theta)
    pulse -= np.einsum('nhw,hw->n', pulse, border)[:, None, None]
    total = pulse.sum(axis=(1, 2))
    safe = np.where(total > 0.0, total, 1.0)
    along_x, along_y = pulse.sum(axis=1), pulse.sum(axis=2)
    columns, rows = np.arange(shape[2]), np.arange(shape[1])
    x, y = along_x @ columns / safe, along_y @ rows / safe
    second = along_x @ columns**2 / safe - x**2 + along_y @ rows**2 / safe - y**2
    return np.stack([x, y, 0.5 * second], axis=1), total

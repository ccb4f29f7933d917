"""Centre of gravity of the light above its background (thesis, eq. 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.location.signal import count_clipped, Signal, signal_above_background
from blob_tracker.types import SensorNoise

FAINTEST = 3.0  # standard deviations of the summed signal: below it the ratio means nothing
LONE_PIXEL = 1.0 / 12.0  # px^2: the second moment of a lone pixel, the least there is


def centroid_1d(signal: ArrayLike) -> NDArray[np.float64]:
    """
    Return sum_k k s_k / sum_k s_k, the centroid of a row of pixels (thesis, eq. 3.2 and 3.13).

    Parameters
    ----------
    signal : (..., n) array
        Light above the background, any unit. A sum over the other axis of a window makes it the
        window's centroid (thesis, eq. 3.28).

    Returns
    -------
    (...) array
        px, the first pixel's centre at 0; NaN where the signal sums to zero.

    """
    values = np.asarray(signal, dtype=float)
    total = values.sum(axis=-1)
    safe = np.where(total == 0.0, np.nan, total)
    return values @ np.arange(values.shape[-1], dtype=float) / safe


@dataclass(frozen=True)
class Moments:
    """
    The moments of N windows, with the failure of those that have none.

    Parameters
    ----------
    total : (N,) array
        Sum of the signal, DN; 1 where there is a failure.
    x, y, width : (N,) array
        Centroid, px, and mean second moment about it along x and y, px^2.
    failure : (N,) uint8 array
        NO_SIGNAL or NONE.

    """

    total: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    width: NDArray[np.float64]
    failure: NDArray[np.uint8]

    def offsets(
        self, signal: Signal
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the (N, 1, w) and (N, h, 1) distances of the pixels from the centroid."""
        height, width = signal.pixels.shape[1:]
        return (
            np.arange(width) - self.x[:, None, None],
            np.arange(height)[:, None] - self.y[:, None, None],
        )


def moments(signal: Signal) -> Moments:
    """Return the sum, the centroid and the second moment of each window."""
    total = signal.pixels.sum(axis=(1, 2))
    ones = np.ones((total.size, 1, *signal.pixels.shape[1:]))
    noise = np.sqrt(signal.spread(ones)[:, 0, 0])
    failure = np.where(total > FAINTEST * noise, Failure.NONE, Failure.NO_SIGNAL)
    ok = failure == Failure.NONE
    total = np.where(ok, total, 1.0)
    pixels = np.where(ok[:, None, None], signal.pixels, 1.0)
    along_x, along_y = pixels.sum(axis=1), pixels.sum(axis=2)
    x, y = centroid_1d(along_x), centroid_1d(along_y)
    dx = np.arange(along_x.shape[1]) - x[:, None]
    dy = np.arange(along_y.shape[1]) - y[:, None]
    width = ((dx**2 * along_x).sum(axis=1) + (dy**2 * along_y).sum(axis=1)) / (2.0 * total)
    return Moments(total, x, y, width, failure.astype(np.uint8))


def centroid(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
) -> Estimates:
    r"""
    Locate N blobs by the background-corrected centroid.

    With the signal s_k = lit_k - unlit_k, or lit_k less the mean of the window's border where
    there is no unlit window,

        x = sum_k k s_k / sum_k s_k                                   (thesis, eq. 3.2)
        Cov = sum_k (r_k - r)(r_k - r)^T v_k / (sum_k s_k)^2

    the second being exact to first order, since x is a ratio of sums that are linear in the
    pixels; v_k is the variance of s_k, and the border's pixels count with what they move
    through the background. Negative s_k stay in: leaving them out would bend the noise into a
    bias. What remains is the skew of the window's edges (thesis, eq. 3.27; `skew_error`), which
    falls below 0.01 px when the window reaches 2.5 sigma to either side; the covariance is
    about the mean and does not hold it.

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
        Failure NO_SIGNAL where the signal does not sum to more than three of its standard
        deviations, OUTSIDE where the centroid leaves the window.

    """
    signal = signal_above_background(lit, unlit, noise)
    found = moments(signal)
    dx, dy = found.offsets(signal)
    shape = signal.pixels.shape
    influence = np.stack([np.broadcast_to(dx, shape), np.broadcast_to(dy, shape)], axis=1)
    covariance = signal.spread(influence / found.total[:, None, None, None])
    failure = outside(found.x, found.y, shape, found.failure)
    # The sum over the window, and the width of the second moment less the pixel's own.
    sigma = np.sqrt(np.maximum(found.width - LONE_PIXEL, LONE_PIXEL))
    amplitude = found.total / (2.0 * np.pi * sigma**2)
    model = amplitude[:, None, None] * (
        integrated_profile(shape[1], found.y, sigma)[0][:, :, None]
        * integrated_profile(shape[2], found.x, sigma)[0][:, None, :]
    )
    snr, chi2 = signal.quality(amplitude, model, 5, noise)
    return Estimates(
        x=found.x,
        y=found.y,
        covariance=covariance,
        amplitude=amplitude,
        background=signal.background,
        sigma=sigma,
        snr=snr,
        chi2=chi2,
        saturated=count_clipped(lit, saturation),
        failure=failure,
    )

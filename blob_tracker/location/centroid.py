"""Centre of gravity of the light above its background (thesis, eq. 3.2)."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.likelihood import empty_profiles, fill_profile
from blob_tracker.location.moments import misfit, Moments, moments
from blob_tracker.location.signal import count_clipped
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import ArrayLike, NDArray

LONE_PIXEL_PX2 = 1.0 / 12.0  # px^2: the second moment of a lone pixel, the least there is

_NONE = int(Failure.NONE)


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


def centroid(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
) -> Estimates:
    r"""
    Locate N blobs by the background-corrected centroid.

    With the signal s_k = lit_k - unlit_k, or lit_k less the mean of the window's corners
    (`corner_weights`) if there is no unlit window,

        x = sum_k k s_k / sum_k s_k                                   (thesis, eq. 3.2)
        Cov = sum_k (r_k - r)(r_k - r)^T v_k / (sum_k s_k)^2

    the second being exact to first order, since x is a ratio of sums that are linear in the
    pixels; v_k is the variance of s_k, and the corners' pixels count with what they move
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
        Failure NO_SIGNAL where the signal does not sum to more than two of its standard
        deviations, OUTSIDE where the centroid leaves the window.

    """
    found = moments(lit, unlit, noise)
    failure = outside(found.value[:, 0], found.value[:, 1], lit.shape, found.failure)
    # Amplitude, sigma, SNR, chi2.
    table = np.zeros((4, lit.shape[0]))
    _describe(
        lit, lit[:0] if unlit is None else unlit, 1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0, found, failure, table,
    )
    amplitude, sigma, snr, chi2 = table
    return Estimates(
        x=found.value[:, 0],
        y=found.value[:, 1],
        covariance=found.covariance[:, :2, :2],
        amplitude=amplitude,
        background=found.background,
        sigma=sigma,
        snr=snr,
        chi2=chi2,
        saturated=count_clipped(lit, saturation),
        failure=failure,
    )


@kernel
def _describe(
    lit: Array,
    unlit: Array,
    shot: float,
    floor: float,
    found: Moments,
    failure: NDArray[np.uint8],
    table: Array,
) -> None:
    """Fill the table with what the pulse looks like that has these moments and this sum."""
    count, height, width = lit.shape
    profiles = empty_profiles(height, width)
    for n in range(count):
        if failure[n] != _NONE:
            continue
        x, y, second = found.value[n]
        # The sum over the window, and the width of the second moment less the pixel's own.
        sigma = math.sqrt(max(second - LONE_PIXEL_PX2, LONE_PIXEL_PX2))
        amplitude = found.total[n] / (2.0 * math.pi * sigma**2)
        fill_profile(x, sigma, profiles.across)
        fill_profile(y, sigma, profiles.down)
        table[0, n] = amplitude
        table[1, n] = sigma
        table[2, n], table[3, n] = misfit(
            lit, unlit, n, shot, floor, amplitude, found.background[n], profiles
        )

"""Centre of gravity of the light above its background (thesis, eq. 3.2)."""

from __future__ import annotations

from blob_tracker.location.estimates import Estimates, Failure
from blob_tracker.location.noise import pixel_variance
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray


def centroid(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
) -> Estimates:
    r"""
    Locate N blobs by the background-corrected centroid.

    With the signal s_k = lit_k - unlit_k, or lit_k less the median of the window's border where
    there is no unlit window,

        x = sum_k k s_k / sum_k s_k                                   (thesis, eq. 3.2)
        Cov = sum_k (r_k - r)(r_k - r)^T v_k / (sum_k s_k)^2

    the second being exact to first order, since x is a ratio of sums that are linear in the
    pixels; v_k is the variance of s_k. Negative s_k stay in: leaving them out would bend the
    noise into a bias. What remains is the skew of the window's edges (thesis, eq. 3.27), which
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
    count, height, width = lit.shape
    if unlit is None:
        border = np.ones((height, width), dtype=bool)
        border[1:-1, 1:-1] = False
        background = np.median(lit[:, border], axis=1)
        signal = lit - background[:, None, None]
        variance = pixel_variance(lit, noise)
    else:
        background = unlit.mean(axis=(1, 2))
        signal = lit - unlit
        variance = pixel_variance(lit, noise) + pixel_variance(unlit, noise)

    columns = np.arange(width, dtype=float)
    rows = np.arange(height, dtype=float)
    total = signal.sum(axis=(1, 2))
    failure = np.zeros(count, dtype=np.uint8)
    failure[total <= 3.0 * np.sqrt(variance.sum(axis=(1, 2)))] = Failure.NO_SIGNAL
    safe = np.where(failure == Failure.NONE, total, 1.0)
    along_x = signal.sum(axis=1)
    along_y = signal.sum(axis=2)
    x = along_x @ columns / safe
    y = along_y @ rows / safe
    outside = (x < -0.5) | (x > width - 0.5) | (y < -0.5) | (y > height - 0.5)
    failure[outside & (failure == Failure.NONE)] = Failure.OUTSIDE

    dx = columns[None, :] - x[:, None]
    dy = rows[None, :] - y[:, None]
    covariance = np.empty((count, 2, 2))
    covariance[:, 0, 0] = np.einsum('nw,nw->n', dx**2, variance.sum(axis=1))
    covariance[:, 1, 1] = np.einsum('nh,nh->n', dy**2, variance.sum(axis=2))
    covariance[:, 0, 1] = np.einsum('nh,nhw,nw->n', dy, variance, dx)
    covariance[:, 1, 0] = covariance[:, 0, 1]
    covariance /= (safe**2)[:, None, None]

    # Width from the second moment; a noisy window can drive it negative: 1/12 is a lone pixel.
    moment = (np.einsum('nw,nw->n', dx**2, along_x) + np.einsum('nh,nh->n', dy**2, along_y)) / 2
    sigma = np.sqrt(np.maximum(moment / safe, 1.0 / 12.0))
    amplitude = total / (2.0 * np.pi * sigma**2)
    shape = np.exp(-(dx**2) / (2 * sigma[:, None] ** 2))[:, None, :]
    shape = shape * np.exp(-(dy**2) / (2 * sigma[:, None] ** 2))[:, :, None]
    residual = signal - amplitude[:, None, None] * shape
    peak = pixel_variance(amplitude + background, noise)
    if unlit is not None:
        peak = peak + pixel_variance(background, noise)
    clipped = np.zeros(count, dtype=np.int64)
    if saturation is not None:
        clipped = (lit >= saturation).sum(axis=(1, 2))
    return Estimates(
        x=x,
        y=y,
        covariance=covariance,
        amplitude=amplitude,
        background=background,
        sigma=sigma,
        snr=amplitude / np.sqrt(peak),
        chi2=(residual**2 / variance).sum(axis=(1, 2)) / max(height * width - 5, 1),
        saturated=clipped,
        failure=failure,
    )

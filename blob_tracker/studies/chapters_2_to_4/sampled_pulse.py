"""The thesis' test pulses: sampled at the pixels' middles, at sub-pixel places, rounded."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.location import locate_batch
from blob_tracker.location.centroid import centroid_1d
from blob_tracker.location.limits import cramer_rao_bound, cramer_rao_bound_1d
from blob_tracker.location.multi_gaussian import LAMP_AMPLITUDES, LAMP_WIDTHS
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]

# Each step is added to the last, as a loop does: the sum decides which halves round up.
FINE = np.cumsum([-0.5] + 49 * [0.02])  # px: chapter 3 and section 4.2
# The step of section 4.3 is not printed. Of the multiples of 0.005 px up to 0.25 px this one
# alone gives the SNR of Table 4.6, and all ten of Tables 4.6 and 4.9 to the last digit.
COARSE = np.cumsum([-0.5] + 11 * [0.09])  # px
ROUNDING = 1.0 / 12.0  # DN^2: the variance of an error that is even over one DN
NO_NOISE = SensorNoise(gain=np.inf, read_noise=0.0)


@dataclass(frozen=True)
class Blob:
    """
    A sum of Gaussians with one mean, A exp(-(r / s)^2).

    Parameters
    ----------
    amplitudes : tuple of float
        DN.
    widths : tuple of float
        s of each over the s of the first.
    centred : bool
        The window's middle is its middle pixel's; else it is w / 2, the pixels counted from 0,
        half a pixel beside it (thesis, sections 4.3.2 and 4.3.4).

    """

    amplitudes: tuple[float, ...]
    widths: tuple[float, ...]
    centred: bool

    def middle(self, count: int) -> float:
        """Return the middle of a window of so many pixels, px from the first pixel's."""
        return (count - 1) / 2 if self.centred else count / 2


ONE = Blob((255.0,), (1.0,), centred=True)
THREE = Blob(LAMP_AMPLITUDES, LAMP_WIDTHS, centred=False)


def rows(blob: Blob, count: int, s: float, shifts: Numbers) -> Numbers:
    """
    Return a row of pixels for each displacement (thesis, eq. 4.1 and 4.32).

    Parameters
    ----------
    blob : Blob
        What is sampled.
    count : int
        Pixels.
    s : float
        px; sqrt2 standard deviations.
    shifts : (M,) array
        Displacements of the mean from the middle, px.

    Returns
    -------
    (M, count) array
        DN.

    """
    amplitudes = np.array(blob.amplitudes)
    return np.tensordot(amplitudes, _profiles(blob, count, s, shifts), 1)


def windows(blob: Blob, size: int, s: float, shifts: Numbers) -> tuple[Numbers, Numbers]:
    """
    Return a window for each pair of displacements (thesis, eq. 4.9 and 4.35), and the true x.

    The arguments are those of `rows`; the (M^2, size, size) windows are in DN, the (M^2,) places
    in px from the first pixel.
    """
    profiles = _profiles(blob, size, s, shifts)
    stack = np.einsum(
        'l,lyj,lxi->yxji', np.array(blob.amplitudes), profiles, profiles
    ).reshape(-1, size, size)
    return stack, blob.middle(size) + np.tile(shifts, shifts.size)


def _profiles(blob: Blob, count: int, s: float, shifts: Numbers) -> Numbers:
    """Return the (L, M, count) profiles of the unit Gaussians."""
    # From the middle, not from the first pixel: the sum would be rounded, and tip halves over.
    distance = np.arange(count) - blob.middle(count) - np.asarray(shifts)[:, None]
    return np.exp(-((distance / (s * np.array(blob.widths)[:, None, None])) ** 2))


def rounded(values: Numbers) -> Numbers:
    """
    Return the integer part of value + 1/2, which rounds what is above zero to the nearest.

    Below zero it rounds up: it is a program's cast to an integer, and Table 3.5 shows it.
    """
    return np.trunc(values + 0.5)


def locate_stack(stack: Numbers, method: str) -> Numbers:
    """Return the (N,) x of (N, h, w) windows without background, px; NaN if there is none."""
    if method == 'centroid':
        # Without the room's demand that a window holds signal: its noise is what is studied.
        return centroid_1d(stack.sum(axis=1))
    found = locate_batch(stack, np.zeros_like(stack), method=method, noise=NO_NOISE)
    return np.where(found.ok, found.x, np.nan)


def error_summary(error: Numbers) -> list[float]:
    """Return least, mean, variance (with n - 1) and largest of the absolute errors."""
    size = np.abs(error[np.isfinite(error)])
    return [float(v) for v in (size.min(), size.mean(), size.var(ddof=1), size.max())]


def signal_to_noise(signal: Numbers, error: Numbers) -> Numbers:
    """Return sqrt(sum g^2 / sum e^2) of each window or row (thesis, page 37)."""
    axes = tuple(range(1, signal.ndim))
    return np.sqrt((signal**2).sum(axis=axes) / (error**2).sum(axis=axes))


def bound(blob: Blob, size: int, s: float, variance: float) -> float:
    """
    Return the Cramer-Rao bound on x, px: the rms over the displacements.

    For square windows with a known background, every amplitude and width to be found, and noise
    of one variance, DN^2; NaN where the window does not determine them.
    """
    try:
        squares = [
            cramer_rao_bound(
                (size, size), x=blob.middle(size) + dx, y=blob.middle(size) + dy,
                sigma=s * np.array(blob.widths) / np.sqrt(2.0), amplitude=blob.amplitudes,
                background=0.0, noise=NO_NOISE, unlit=True, sampled=True,
            )[0, 0]
            for dx in COARSE[::3] for dy in COARSE[::3]
        ]
    except ValueError:
        return np.nan
    # What was asked for is that of two windows, each with the noise of rounding.
    return float(np.sqrt(np.mean(squares) * variance / (2.0 * ROUNDING)))


def row_bound(blob: Blob, count: int, s: float, shift: float, variance: float) -> float:
    """Return the same for a row of pixels and one displacement, px."""
    try:
        return float(np.sqrt(cramer_rao_bound_1d(
            count, x=blob.middle(count) + shift, sigma=s * np.array(blob.widths) / np.sqrt(2.0),
            amplitude=blob.amplitudes, variance=variance, sampled=True,
        )))
    except ValueError:
        return np.nan

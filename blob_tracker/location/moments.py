"""The first and second moments of the light in a window, and how the noise moves them."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Failure
from blob_tracker.location.likelihood import Profiles
from blob_tracker.location.signal import corner_weights
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

FAINTEST_SIGMA = 2.0  # standard deviations of the summed signal: below it the ratio means nothing

_NONE, _NO_SIGNAL = int(Failure.NONE), int(Failure.NO_SIGNAL)


class Moments(NamedTuple):
    """
    The moments of N windows, with the failure of those that have none.

    Parameters
    ----------
    value : (N, 3) array
        Centroid x, y, px, and mean second moment about it along x and y, px^2.
    covariance : (N, 3, 3) array
        Of the value, px^2, px^3 and px^4; the moments are ratios of sums that are linear in the
        pixels, so it is exact to first order. A pixel that the background is taken from also
        counts with what it moves through the background.
    total : (N,) array
        Sum of the signal, DN.
    background : (N,) array
        Level that was taken off (its mean where it was a window), DN.
    failure : (N,) uint8 array
        NO_SIGNAL or NONE.

    """

    value: Array
    covariance: Array
    total: Array
    background: Array
    failure: NDArray[np.uint8]


def moments(lit: Array, unlit: Array | None, noise: SensorNoise) -> Moments:
    """Return the moments of (N, h, w) windows: of lit - unlit, or lit less its corners' mean."""
    count = lit.shape[0]
    found = Moments(
        np.zeros((count, 3)), np.zeros((count, 3, 3)), np.ones(count), np.zeros(count),
        np.zeros(count, dtype=np.uint8),
    )
    _moments_of_all(
        lit, lit[:0] if unlit is None else unlit, 1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0, corner_weights(lit.shape[1], lit.shape[2]), found,
    )
    return found


@kernel
def _moments_of_all(
    lit: Array, unlit: Array, shot: float, floor: float, corners: Array, found: Moments
) -> None:
    """Fill `found`; `shot` is 1 / gain, `floor` the variance of a dark pixel, DN^2."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    signal = np.empty((height, width))
    variance = np.empty((height, width))
    influence = np.empty(3)
    lift = np.empty(3)
    for n in range(count):
        background = 0.0
        for j in range(height):
            for i in range(width):
                if paired:
                    background += unlit[n, j, i] / (height * width)
                else:
                    background += corners[j, i] * lit[n, j, i]
        total, x, y, scatter = 0.0, 0.0, 0.0, 0.0
        for j in range(height):
            for i in range(width):
                signal[j, i] = lit[n, j, i] - background
                variance[j, i] = max(lit[n, j, i], 0.0) * shot + floor
                lifted = 1.0
                if paired:
                    signal[j, i] = lit[n, j, i] - unlit[n, j, i]
                    variance[j, i] += max(unlit[n, j, i], 0.0) * shot + floor
                else:
                    lifted -= height * width * corners[j, i]
                total += signal[j, i]
                x += i * signal[j, i]
                y += j * signal[j, i]
                scatter += lifted * lifted * variance[j, i]
        found.background[n] = background
        if not total > FAINTEST_SIGMA * math.sqrt(scatter):
            found.failure[n] = _NO_SIGNAL
            continue
        x /= total
        y /= total
        second = 0.0
        lift[:] = 0.0
        for j in range(height):
            for i in range(width):
                square = 0.5 * ((i - x) ** 2 + (j - y) ** 2)
                second += square * signal[j, i] / total
                lift[0] += i - x
                lift[1] += j - y
                lift[2] += square
        lift[2] -= height * width * second
        for j in range(height):
            for i in range(width):
                influence[0] = i - x
                influence[1] = j - y
                influence[2] = 0.5 * ((i - x) ** 2 + (j - y) ** 2) - second
                for p in range(3):
                    if not paired:
                        influence[p] -= lift[p] * corners[j, i]
                    for q in range(p + 1):
                        found.covariance[n, p, q] += influence[p] * influence[q] * variance[j, i]
        for p in range(3):
            for q in range(p + 1):
                found.covariance[n, p, q] /= total * total
                found.covariance[n, q, p] = found.covariance[n, p, q]
        found.total[n] = total
        found.value[n, 0] = x
        found.value[n, 1] = y
        found.value[n, 2] = second


@kernel
def misfit(
    lit: Array, unlit: Array, n: int, shot: float, floor: float, amplitude: float, level: float,
    profiles: Profiles,
) -> tuple[float, float]:
    """
    Return the SNR of a pulse's peak and its chi2 per degree of freedom, for window n.

    `level` is what is below the pulse, DN; `unlit` is empty if there is no such window.
    """
    height, width = lit.shape[1:]
    across, down = profiles
    paired = unlit.shape[0] > 0
    squares = 0.0
    for j in range(height):
        for i in range(width):
            residual = lit[n, j, i] - level - amplitude * down[0, j] * across[0, i]
            variance = max(lit[n, j, i], 0.0) * shot + floor
            if paired:
                residual -= unlit[n, j, i] - level
                variance += max(unlit[n, j, i], 0.0) * shot + floor
            squares += residual * residual / variance
    peak = max(amplitude + level, 0.0) * shot + floor
    if paired:
        peak += max(level, 0.0) * shot + floor
    return amplitude / math.sqrt(peak), squares / max(height * width - 5, 1)

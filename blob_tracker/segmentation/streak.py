"""The ends and the width of a streak: of a light that moves while it is exposed."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Pixels
import numpy as np

LONGER = 2.4  # times as long as wide: what is less long is measured well by its moments
FARTHEST = 48  # px from the middle: what has no end within it is an edge or a band
WIDEST = 12  # px to either side of the line
LEVELS = (0.25, 0.5, 0.75)  # of the plateau
FWHM = 2.355  # sigmas: the full width of a Gaussian at half its height
FALL = 1.35  # sigmas, in which the end of a streak falls from 3/4 to 1/4 of its plateau
SOFTEST = 2.0  # times that: a bar that is a long Gaussian, or fades out, falls more slowly
SMOOTHING_PX = 1.0  # px that the samples add to it

Blob = tuple[float, float, float, float, float, float, float, float, float]


@kernel
def measure_streak(
    lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int], saturation: int, blob: Blob
) -> tuple[bool, Blob]:
    """
    Return whether a long blob is an even line with two ends, and its moments if it is.

    Along its axis such a line has a plateau that falls at either end as steeply as it does
    across. The moving edge of something large has no ends, and what fades out is no light that
    was dragged. Clipped pixels have no plateau.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    region : (int, int, int, int)
        Columns x0 to x1 and rows y0 to y1, px.
    saturation : int
        The DN at which a pixel is clipped.
    blob : tuple of 9 floats
        What `adaptive_moments.measure` returns.

    """
    x, y, sigma_x, sigma_y, major, minor, correlation, snr, level = blob
    if major < LONGER * minor:
        return False, blob
    angle = 0.5 * np.arctan2(
        2.0 * correlation * sigma_x * sigma_y, sigma_x * sigma_x - sigma_y * sigma_y
    )
    u, v = np.cos(angle), np.sin(angle)
    x, y = np.floor(x + 0.5), np.floor(y + 0.5)  # whose samples are where they are said to be
    along = np.empty(2 * FARTHEST + 1)
    for k in range(along.size):
        along[k] = 0.0
        for side in (-1, 0, 1):
            value = _sample(
                lit, unlit, region, saturation, x + (k - FARTHEST) * u - side * v,
                y + (k - FARTHEST) * v + side * u, level,
            )
            along[k] += value / 3.0
    middle = FARTHEST
    near = along[middle - int(minor) - 1:middle + int(minor) + 2]
    plateau = near.mean()
    if not (0.0 < plateau < np.inf):
        return False, blob
    lengths = np.empty(3)
    start, end = 0.0, 0.0
    for index, part in enumerate(LEVELS):
        first = _crossing(along, middle, -1, part * plateau)
        last = _crossing(along, middle, 1, part * plateau)
        if first < 0.0 or last < 0.0:
            return False, blob
        lengths[index] = first + last
        if part == 0.5:
            start, end = -first, last
    across = np.zeros(2 * WIDEST + 1)
    for k in range(int(np.ceil(start)), int(end) + 1):
        for side in range(-WIDEST, WIDEST + 1):
            across[side + WIDEST] += _sample(
                lit, unlit, region, saturation, x + k * u - side * v, y + k * v + side * u, level
            )
    peak = across[WIDEST - 1:WIDEST + 2].max()
    left = _crossing(across, WIDEST, -1, 0.5 * peak)
    right = _crossing(across, WIDEST, 1, 0.5 * peak)
    if left < 0.0 or right < 0.0:
        return False, blob
    width = max((left + right) / FWHM, 0.5)
    if lengths[0] - lengths[2] > 2.0 * (SOFTEST * FALL * width + SMOOTHING_PX):
        return False, blob
    middle_x, middle_y = x + 0.5 * (start + end) * u, y + 0.5 * (start + end) * v
    middle_x -= 0.5 * (right - left) * v
    middle_y += 0.5 * (right - left) * u
    variance = (end - start) ** 2 / 12.0
    xx, yy = variance * u * u + width * width, variance * v * v + width * width
    return True, (
        middle_x, middle_y, np.sqrt(xx), np.sqrt(yy), np.sqrt(variance + width * width), width,
        variance * u * v / np.sqrt(xx * yy), snr, level,
    )


@kernel
def _sample(
    lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int], saturation: int, x: float,
    y: float, level: float,
) -> float:
    """Return lit less unlit at the nearest pixel, DN; infinite where it is clipped or outside."""
    i, j = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
    if not (region[0] <= i < region[2] and region[1] <= j < region[3]):
        return np.inf
    if lit[j, i] >= saturation:
        return np.inf
    return float(lit[j, i]) - float(unlit[j, i]) - level


@kernel
def _crossing(profile: Array, middle: int, step: int, level: float) -> float:
    """Return how far from the middle a profile falls below a level; -1 where it does not."""
    k = middle
    while 0 <= k + step < profile.size:
        here, beyond = profile[k], profile[k + step]
        if not here < np.inf or not beyond < np.inf:
            return -1.0
        if beyond < level <= here:
            return abs(k - middle) + (here - level) / (here - beyond)
        k += step
    return -1.0

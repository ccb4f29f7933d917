"""Level and noise of a difference of two frames, tile by tile."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Pixels
import numpy as np

TILE_PX = 128  # px: wide enough for 256 samples and more, small enough to follow shade and texture
ROWS = 8  # of a tile that are sampled: the noise is known to 4 %
LAG_PX = 8  # px between the two pixels compared, beyond the reach of a codec's or a lens' blur
# Sigma over the mean |d1 - d2| of two Gaussian deviates
SIGMA_PER_MEAN_DIFFERENCE = 0.5 * np.sqrt(np.pi)


@kernel
def tile_noise(
    lit: Pixels, unlit: Pixels, x0: int, y0: int, x1: int, y1: int, floor: float
) -> tuple[Array, Array, Array]:
    """
    Return level, noise and brightness of the difference in each tile of a region.

    The noise is the mean of |d(i) - d(i + 8)| over a row of the tile, times sqrt(pi) / 2, and of
    the rows the median. A shade that the light lays over the tile leaves it as it is, because
    neighbours share it; and so do a target, a lamp or an edge, which are on few of the rows.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, uint8 or uint16.
    x0, y0, x1, y1 : int
        The region, px.
    floor : float
        Least noise, DN: that of the rounding.

    Returns
    -------
    levels, noises, brightness : three (rows, columns) arrays
        Of each tile the median over its rows of the mean difference and of the noise, and the
        mean of `unlit`, DN.

    """
    across = max((x1 - x0 + TILE_PX // 2) // TILE_PX, 1)
    down = max((y1 - y0 + TILE_PX // 2) // TILE_PX, 1)
    levels = np.empty((down, across))
    noises = np.empty((down, across))
    brightness = np.empty((down, across))
    step = max((y1 - y0) // (down * ROWS), 1)
    most = 3 * ROWS
    means = np.empty((across, most))
    spreads = np.empty((across, most))
    unlits = np.empty((across, most))
    lag = min(LAG_PX, (x1 - x0) // 4)
    for ty in range(down):
        top, bottom = y0 + ty * TILE_PX, y0 + (ty + 1) * TILE_PX
        if ty == down - 1:
            bottom = y1
        count = 0
        for j in range(top + step // 2, bottom, step):
            if count == most:
                break
            a, b = lit[j], unlit[j]
            for tx in range(across):
                left, right = x0 + tx * TILE_PX, x0 + (tx + 1) * TILE_PX
                if tx == across - 1:
                    right = x1
                means[tx, count], spreads[tx, count], unlits[tx, count] = _row_means(
                    a, b, left, right, lag
                )
            count += 1
        for tx in range(across):
            levels[ty, tx] = median(means[tx], count)
            noises[ty, tx] = max(SIGMA_PER_MEAN_DIFFERENCE * median(spreads[tx], count), floor)
            brightness[ty, tx] = unlits[tx, :count].mean()
    return levels, noises, brightness


@kernel
def median(values: Array, count: int) -> float:
    """Return the median of the first values; they are sorted in place."""
    # By comparisons that are all made, whatever the values: a branch that none foresees costs more
    # than moving all of the few that there are.
    for i in range(1, count):
        value = values[i]
        for k in range(i, 0, -1):
            before = values[k - 1]
            is_less = value < before
            values[k] = before if is_less else value
            value = value if is_less else before
        values[0] = value
    return 0.5 * (values[(count - 1) // 2] + values[count // 2])


@kernel
def _row_means(
    a: Pixels, b: Pixels, left: int, right: int, lag: int
) -> tuple[float, float, float]:
    """Return the means of d = a - b, of |d(i) - d(i + lag)|, and of b, from left to right."""
    # Indices that cannot be negative and sums of 32 bits: what the compiler puts into vectors.
    later = np.uint64(lag)
    level, spread, bright = np.int32(0), np.int32(0), np.int32(0)
    for i in range(np.uint64(left), np.uint64(right - lag)):
        here = np.int32(a[i]) - np.int32(b[i])
        there = np.int32(a[i + later]) - np.int32(b[i + later])
        level += np.int32(here)
        spread += np.int32(abs(here - there))
        bright += np.int32(b[i])
    count = right - lag - left
    return level / count, spread / count, bright / count

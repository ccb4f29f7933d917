"""Light on the whole scene that changes between frames: lamps on the mains, clouds, bands."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.tile_noise import median
from blob_tracker.types import Pixels
import numpy as np

# Of a region so many rows are sampled, and so far apart at least: between them a band is on a
# straight line.
ROWS, ROWS_APART_PX = 32, 4
PARTS = 5  # of a row, whose median it is: a target or a lamp is in two of them at most
DARK_DN = 4.0  # DN: of less the ratio says nothing


@kernel
def row_gains(lit: Pixels, unlit: Pixels, y0: int, y1: int) -> tuple[Array, float]:
    """
    Return how the light on the scene changed, over the whole width of some rows.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous.
    y0, y1 : int
        The rows, px.

    Returns
    -------
    gains : (n, 2) array
        Number of each row that was sampled, px, and how many times brighter it is than in `unlit`.
    change : float
        How much brighter or darker it is, rms over the rows, DN.

    """
    count = max(min(ROWS, (y1 - y0) // ROWS_APART_PX), 1)
    gains = np.empty((count, 2))
    ratios = np.empty(PARTS)
    width = lit.shape[1] // PARTS
    squares = 0.0
    for k in range(count):
        j = y0 + (2 * k + 1) * (y1 - y0) // (2 * count)
        a, b = lit[j], unlit[j]
        total = 0.0
        for part in range(PARTS):
            after, before = _sums(a, b, part * width, (part + 1) * width)
            total += before
            ratios[part] = after / before if before >= DARK_DN * width and width > 0 else 1.0
        gain = median(ratios, PARTS)
        gains[k, 0], gains[k, 1] = j, gain
        squares += ((gain - 1.0) * total / lit.shape[1]) ** 2
    return gains, np.sqrt(squares / count)


@kernel
def _sums(a: Pixels, b: Pixels, left: int, right: int) -> tuple[float, float]:
    """Return the sums of two rows from left to right."""
    first, second = np.int32(0), np.int32(0)
    for i in range(np.uint64(left), np.uint64(right)):
        first += np.int32(a[i])
        second += np.int32(b[i])
    return float(first), float(second)


@kernel
def relit(unlit: Pixels, gains: Array, saturation: int) -> Pixels:
    """
    Return the unlit frame in the light of the lit one, row by row.

    A rolling shutter exposes one row after the other, and so a lamp that flickers brightens some
    of them: I'(x, y) = g(y) I(x, y), with g between the sampled rows on straight lines.

    Parameters
    ----------
    unlit : (h, w) array
        DN.
    gains : (n, 2) array
        Rows in their order, px, and g in them.
    saturation : int
        The DN at which a pixel is clipped.

    Returns
    -------
    (h, w) array
        DN, of the type of `unlit`.

    """
    out = np.empty_like(unlit)
    last = gains.shape[0] - 1
    k = 0
    for j in range(unlit.shape[0]):
        while k < last - 1 and gains[k + 1, 0] < j:
            k += 1
        gain = gains[k, 1]
        if last > 0:
            along = (j - gains[k, 0]) / (gains[k + 1, 0] - gains[k, 0])
            gain += min(max(along, 0.0), 1.0) * (gains[k + 1, 1] - gain)
        line, to = unlit[j], out[j]
        factor = np.float32(gain)
        most = np.float32(saturation)
        for i in range(np.uint64(line.size)):
            to[i] = unlit.dtype.type(min(np.float32(line[i]) * factor + np.float32(0.5), most))
    return out

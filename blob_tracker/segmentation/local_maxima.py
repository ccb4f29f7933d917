"""Where light rose: the local maxima of lit less unlit, tile by tile."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.tile_noise import TILE_PX
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

BAND_FRACTION = 0.25  # of a row above the threshold: the row is brighter, not something in it
# Pixels of a tile's row above the threshold: of such only the highest is looked at
CROWDED_PX = 32


@kernel
def local_maxima(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    mask: NDArray[np.uint8],
    levels: Array,
    noises: Array,
    rises: Array,
    threshold: float,
    peaks: Array,
) -> tuple[int, float]:
    """
    Write down column, row and height of the peaks, as far as there is room.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, of one type.
    region : (int, int, int, int)
        Columns x0 to x1 and rows y0 to y1, px.
    mask : (h, w) or (0, 0) array
        0 where no peak counts; empty if each does.
    levels, noises : (down, across) arrays
        Level of lit less unlit and its standard deviation in each tile, DN.
    rises : (y1 - y0,) array
        Greatest of each row, see `greatest_rises`.
    threshold : float
        Least height, in standard deviations of the peak's tile.
    peaks : (n, 3) array
        Gets column and row, px, and height above the level, DN.

    Returns
    -------
    count : int
        How many there are, also beyond n.
    strongest : float
        Greatest rise of any pixel above the level, DN.

    """
    x0, y0, x1, y1 = region
    down, across = noises.shape
    count, strongest = 0, 0.0
    lowest, darkest = np.empty(down), np.empty(down)  # of each row of tiles
    floors = np.empty((down, across))
    for ty in range(down):
        for tx in range(across):
            floors[ty, tx] = _lowest_level(levels, tx, ty)
        lowest[ty] = (floors[ty] + threshold * noises[ty]).min()
        darkest[ty] = floors[ty].min()
    marks = np.empty(2 * TILE_PX, np.bool_)  # of a tile's row
    # Most rows hold nothing: one look at each whole row, with the least of its thresholds.
    for j in range(y0, y1):
        ty = min((j - y0) // TILE_PX, down - 1)
        strongest = max(strongest, rises[j - y0] - darkest[ty])
        if rises[j - y0] <= lowest[ty]:
            continue
        a, b = lit[j], unlit[j]
        brighter = -1.0
        for tx in range(across):
            left = x0 + tx * TILE_PX
            right = x1 if tx == across - 1 else left + TILE_PX
            level = floors[ty, tx]
            highest = float(_greatest_rise(a, b, left, right)) - level
            least = threshold * noises[ty, tx]
            if highest <= least:
                continue
            crowded = _count_above(a, b, left, right, int(level + least)) > CROWDED_PX
            if crowded:
                if brighter < 0.0:
                    brighter = _level_of_band(a, b, x0, x1, level, least)
                if highest <= brighter + least:
                    continue
            least = max(brighter, 0.0) + level + least
            if crowded:
                _mark_above(marks, a, b, left, right, max(least, highest + level - 0.5))
            elif not _mark_peaks(marks, lit, unlit, region, j, left, right, least):
                continue
            for i in range(left, right):
                if not marks[i - left] or (mask.size > 0 and mask[j, i] == 0):
                    continue
                height = _rise(lit, unlit, i, j) - level_at(levels, i - x0, j - y0)
                if height <= threshold * noises[ty, tx]:
                    continue
                if count < peaks.shape[0]:
                    peaks[count, 0], peaks[count, 1], peaks[count, 2] = i, j, height
                count += 1
                if crowded:
                    break
    return count, strongest


@kernel
def greatest_rises(lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int]) -> Array:
    """
    Return the greatest lit less unlit in each row of a region, DN, 0 where all is negative.

    It takes all pixels in their order, as they come fastest from memory: what looks at some of
    them then finds them in the cache.
    """
    x0, y0, x1, y1 = region
    rises = np.empty(y1 - y0)
    for j in range(y0, y1):
        rises[j - y0] = _greatest_rise(lit[j], unlit[j], x0, x1)
    return rises


@kernel
def level_at(levels: Array, x: float, y: float) -> float:
    """Return the level at a place, px from the first tile, between the tiles' middles."""
    down, across = levels.shape
    v, u = y / TILE_PX - 0.5, x / TILE_PX - 0.5
    top, left = max(min(int(v), down - 2), 0), max(min(int(u), across - 2), 0)
    below, right = min(top + 1, down - 1), min(left + 1, across - 1)
    v, u = v - top, u - left
    upper = levels[top, left] + u * (levels[top, right] - levels[top, left])
    lower = levels[below, left] + u * (levels[below, right] - levels[below, left])
    return upper + v * (lower - upper)


@kernel
def _lowest_level(levels: Array, tx: int, ty: int) -> float:
    """Return the least level at the four corners of a tile."""
    lowest = levels[ty, tx]
    for y in (ty, ty + 1):
        for x in (tx, tx + 1):
            lowest = min(lowest, level_at(levels, float(x * TILE_PX), float(y * TILE_PX)))
    return lowest


@kernel
def brightest_square(
    lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int], mask: NDArray[np.uint8]
) -> tuple[int, int, float]:
    """Return the middle of the 3 x 3 pixels that rose most, and their mean rise, DN."""
    x0, y0, x1, y1 = region
    # Sums of three pixels of a row, three rows in turn.
    rows = np.zeros((3, max(x1 - x0 - 2, 0)), np.int32)
    inside = np.uint64(rows.shape[1])
    first, one, two = np.uint64(x0), np.uint64(1), np.uint64(2)
    best = np.int32(-(2**30))
    column, row = x0, y0
    for j in range(np.uint64(y0), np.uint64(y1)):
        turn = j % np.uint64(3)
        for i in range(inside):
            k = first + i
            rows[turn, i] = (
                np.int32(lit[j, k]) - np.int32(unlit[j, k])
                + np.int32(lit[j, k + one]) - np.int32(unlit[j, k + one])
                + np.int32(lit[j, k + two]) - np.int32(unlit[j, k + two])
            )
        if j < y0 + 2:
            continue
        # Most rows hold none that is brighter: one look at each whole row tells.
        greatest = best
        for i in range(inside):
            greatest = max(greatest, np.int32(rows[0, i] + rows[1, i] + rows[2, i]))
        if greatest == best:
            continue
        for i in range(inside):
            total = np.int32(rows[0, i] + rows[1, i] + rows[2, i])
            if total > best and (mask.size == 0 or mask[j - one, first + one + i] != 0):
                best, column, row = total, x0 + 1 + int(i), int(j) - 1
    return column, row, best / 9.0


@kernel
def _greatest_rise(a: Pixels, b: Pixels, left: int, right: int) -> int:
    """Return the maximum of a - b from left to right, 0 where all is negative."""
    # In the type of the pixels: it is as many times faster as they are narrower than an int.
    zero = a.dtype.type(0)
    highest = zero
    for i in range(np.uint64(left), np.uint64(right)):
        highest = max(highest, _no_fall(a, b, i))
    return highest


@kernel
def _count_above(a: Pixels, b: Pixels, left: int, right: int, least: int) -> int:
    """Return how many of a - b are above a level, from left to right."""
    count = np.int32(0)
    bound = np.int32(least)
    for i in range(np.uint64(left), np.uint64(right)):
        count += np.int32(np.int32(a[i]) - np.int32(b[i]) > bound)
    return count


@kernel
def _level_of_band(
    a: Pixels, b: Pixels, left: int, right: int, level: float, least: float
) -> float:
    """
    Return by how much a whole row is brighter than the level, DN, and 0 where it is not.

    A lamp that flickers lights some of the rows of a rolling shutter; a target is on a few pixels
    of its rows only, so that their mean is not moved.
    """
    above, total = 0, 0.0
    for i in range(left, right):
        rise = float(np.int32(a[i]) - np.int32(b[i])) - level
        above += rise > least
        total += rise
    return max(total / (right - left), 0.0) if above > BAND_FRACTION * (right - left) else 0.0


@kernel
def _mark_above(
    marks: NDArray[np.bool_], a: Pixels, b: Pixels, left: int, right: int, least: float
) -> None:
    """Mark where a - b is above a level, from left to right."""
    for i in range(left, right):
        marks[i - left] = float(np.int32(a[i]) - np.int32(b[i])) > least


@kernel
def _mark_peaks(
    marks: NDArray[np.bool_], lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int],
    j: int, left: int, right: int, least: float,
) -> int:
    """Mark the peaks of a row above a level, from left to right; return how many there are."""
    inner, outer = right, right
    if region[1] < j < region[3] - 1 and least >= 0.0:
        inner = max(left, region[0] + 1)
        outer = max(min(right, region[2] - 1), inner)
    count = _mark_inner(
        marks[inner - left:], (lit[j - 1], lit[j], lit[j + 1]),
        (unlit[j - 1], unlit[j], unlit[j + 1]), inner, outer, least,
    ) if inner < outer else 0
    for first, last in ((left, inner), (outer, right)):
        for i in range(first, last):
            rise = _rise(lit, unlit, i, j)
            marks[i - left] = rise > least and _is_peak(lit, unlit, region, i, j, rise)
            count += marks[i - left]
    return count


@kernel
def _mark_inner(
    marks: NDArray[np.bool_], lit: tuple[Pixels, Pixels, Pixels],
    unlit: tuple[Pixels, Pixels, Pixels], left: int, right: int, least: float,
) -> int:
    """Do the same in the middle one of three rows, all of which have pixels to either side."""
    # Without a branch and in the type of the pixels it goes in vectors: most pixels of a blob are
    # on a slope. What fell is 0 there, and so no higher than what rose.
    a, b = lit[1], unlit[1]
    bound, one = a.dtype.type(least), np.uint64(1)
    count = np.uint8(0)  # no two are beside each other
    for i in range(np.uint64(right - left)):
        k = np.uint64(left) + i
        rise = _no_fall(a, b, k)
        is_peak = (
            (rise > bound)
            & (_no_fall(a, b, k - one) < rise) & (_no_fall(a, b, k + one) <= rise)
            & (_no_fall(lit[0], unlit[0], k - one) < rise)
            & (_no_fall(lit[0], unlit[0], k) < rise)
            & (_no_fall(lit[0], unlit[0], k + one) < rise)
            & (_no_fall(lit[2], unlit[2], k - one) <= rise)
            & (_no_fall(lit[2], unlit[2], k) <= rise)
            & (_no_fall(lit[2], unlit[2], k + one) <= rise)
        )
        marks[i] = is_peak
        count = np.uint8(count + np.uint8(is_peak))
    return np.int64(count)


@kernel
def _no_fall(a: Pixels, b: Pixels, i: int) -> int:
    """Return a - b at a pixel in its type, 0 where it is negative."""
    return a.dtype.type(max(a[i], b[i]) - b[i])


@kernel
def _is_peak(
    lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int], i: int, j: int, rise: float
) -> bool:
    """Tell whether no neighbour exceeds a pixel; of equal ones the first is the peak."""
    # Its own row first: it is at hand, and most pixels of a blob are on a slope.
    if i > region[0] and _rise(lit, unlit, i - 1, j) >= rise:
        return False
    if i + 1 < region[2] and _rise(lit, unlit, i + 1, j) > rise:
        return False
    for u in range(max(i - 1, region[0]), min(i + 2, region[2])):
        if j > region[1] and _rise(lit, unlit, u, j - 1) >= rise:
            return False
        if j + 1 < region[3] and _rise(lit, unlit, u, j + 1) > rise:
            return False
    return True


@kernel
def _rise(lit: Pixels, unlit: Pixels, i: int, j: int) -> float:
    """Return lit less unlit at a pixel, DN."""
    return float(np.int32(lit[j, i]) - np.int32(unlit[j, i]))

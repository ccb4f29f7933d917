"""Every peak in a part of a frame, measured: the loops over pixels."""

# Numba's decorators bring no types.
# mypy: disable-error-code="untyped-decorator"

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.adaptive_moments import measure
from blob_tracker.segmentation.illumination import row_gains
from blob_tracker.segmentation.tile_noise import median, TILE, tile_noise
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

FIELDS = 21  # of a candidate
# Of a frame; where there are more peaks only the higher ones are looked at, and of these the
# highest are measured: a field of stars has hundreds. Most frames need no more than FEW, and room
# for more would cost more time than the search.
MOST_PEAKS, FEW_PEAKS = 2048, 128
MOST_CANDIDATES, FEW_CANDIDATES = 1024, 16
FLANK = 4.0  # sigma of a blob within which further peaks are its own
# And as many px further out those that have such a part of its height: the wings of the lens, the
# ringing of a codec. What is brighter is another light beside it.
WING = 0.1
WINDOW = 3.0  # sigma to either side: what is compared with a Gaussian
BAND = 0.25  # of a row above the threshold: the row is brighter, not something in it
SMALL = 65536  # px: a larger region is not near the prediction
CROWDED = 32  # pixels of a tile's row above the threshold: of such only the highest is looked at
FROM_MEAN = np.sqrt(0.5 * np.pi)  # sigma over the mean |d| of a Gaussian deviate
SAMPLES = 12  # to either side of a blob on which it is compared; of wider ones pixels are left out


@kernel
def measure_peaks(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    mask: NDArray[np.uint8],
    floor: float,
    threshold: float,
    least: float,
    largest: float,
    saturation: int,
    alone: bool,
    followed: bool,
) -> tuple[Array, Array, float, float, float, float, float]:
    """
    Return what rose in a region, the highest first, and the noise that it stands in.

    A peak is a pixel that no neighbour exceeds and that stands `threshold` standard deviations of
    its tile above the background. Each is measured by its adaptive moments, and compared with a
    Gaussian and with the scene that it stands in.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, uint8 or uint16.
    region : (int, int, int, int)
        Columns x0 to x1 and rows y0 to y1, px.
    mask : (h, w) or (0, 0) array
        0 where the target cannot be; empty where it may be anywhere.
    floor : float
        Least noise, DN.
    threshold : float
        Least height of a peak, in standard deviations of lit less unlit.
    least : float
        Least SNR in the matched filter.
    largest : float
        Greatest sigma, px.
    saturation : int
        The DN at which a pixel is clipped.
    alone : bool
        Whether nothing was subtracted. The level is then that of the scene, tile by tile; of a
        difference it is one for the whole region.
    followed : bool
        Whether the region is that about a prediction.

    Returns
    -------
    table : (n, 21) array
        A row for each peak of at least that SNR: the fields of `Candidate` in their order.
    gains : (n, 2) array
        How the light on the scene changed, see `row_gains`.
    change : float
        By how much, rms over the rows, DN.
    level, noise, brightness : float
        Median over the tiles of lit less unlit, of its standard deviation, and of unlit, DN.
    strongest : float
        Greatest height of any pixel above the level, DN.

    """
    x0, y0, x1, y1 = region
    gains, change = row_gains(lit, unlit, y0, y1)
    levels, noises, bright = tile_noise(lit, unlit, x0, y0, x1, y1, floor)
    level = np.median(levels)
    if not alone:
        levels[:] = level
    room = FEW_PEAKS
    peaks = np.empty((room, 3))
    count, strongest = _peaks(lit, unlit, region, mask, levels, noises, threshold, peaks)
    while count > room:
        if room < MOST_PEAKS:
            room = MOST_PEAKS
            peaks = np.empty((room, 3))
        else:
            threshold *= 2.0
        count, strongest = _peaks(lit, unlit, region, mask, levels, noises, threshold, peaks)
    table = np.empty((FEW_CANDIDATES, FIELDS))
    found = 0
    for index in np.argsort(-peaks[:count, 2]):
        column, row = int(peaks[index, 0]), int(peaks[index, 1])
        if _on_flank(table[:found], column, row, peaks[index, 2]):
            continue
        ty = min((row - y0) // TILE, noises.shape[0] - 1)
        tx = min((column - x0) // TILE, noises.shape[1] - 1)
        noise, under = noises[ty, tx], _level_at(levels, column - x0, row - y0)
        blob = measure(lit, unlit, region, column, row, under, noise, least, largest)
        # A faint peak in the reach of a brighter light ends in it, or half-way to it.
        if blob[7] >= least and not _wandered(table[:found], blob, column, row):
            _describe(
                table[found], lit, unlit, region, saturation, alone, blob, column, row, noise,
                peaks[index, 2],
            )
            found += 1
            if found == MOST_CANDIDATES:
                break
            if found == table.shape[0]:
                more = np.empty((MOST_CANDIDATES, FIELDS))
                more[:found] = table
                table = more
    if found == 0 and followed and (x1 - x0) * (y1 - y0) <= SMALL:
        # Near the prediction a faint blob is worth a second look: its brightest 3 x 3 pixels.
        column, row, height = _brightest_square(lit, unlit, region, mask)
        ty = min((row - y0) // TILE, noises.shape[0] - 1)
        tx = min((column - x0) // TILE, noises.shape[1] - 1)
        noise, under = noises[ty, tx], _level_at(levels, column - x0, row - y0)
        blob = measure(lit, unlit, region, column, row, under, noise, least, largest)
        if blob[7] >= least:
            _describe(
                table[0], lit, unlit, region, saturation, alone, blob, column, row, noise,
                height - under,
            )
            found = 1
    return table[:found], gains, change, level, np.median(noises), np.median(bright), strongest


@kernel
def _peaks(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    mask: NDArray[np.uint8],
    levels: Array,
    noises: Array,
    threshold: float,
    peaks: Array,
) -> tuple[int, float]:
    """
    Write down column, row and height of the peaks, as far as there is room.

    Return how many there are, and the greatest rise above the level.
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
    # Most rows hold nothing: one look at each whole row, with the least of its thresholds.
    rises = np.empty(y1 - y0)
    for j in range(y0, y1):
        rises[j - y0] = _greatest_rise(lit[j], unlit[j], x0, x1)
    for j in range(y0, y1):
        ty = min((j - y0) // TILE, down - 1)
        strongest = max(strongest, rises[j - y0] - darkest[ty])
        if rises[j - y0] <= lowest[ty]:
            continue
        a, b = lit[j], unlit[j]
        brighter = -1.0
        for tx in range(across):
            left = x0 + tx * TILE
            right = x1 if tx == across - 1 else left + TILE
            level = floors[ty, tx]
            highest = float(_greatest_rise(a, b, left, right)) - level
            least = threshold * noises[ty, tx]
            if highest <= least:
                continue
            crowded = _count_above(a, b, left, right, int(level + least)) > CROWDED
            if crowded:
                if brighter < 0.0:
                    brighter = _level_of_band(a, b, x0, x1, level, least)
                if highest <= brighter + least:
                    continue
            least = max(brighter, 0.0) + level + least
            for i in range(left, right):
                rise = float(np.int32(a[i]) - np.int32(b[i]))
                if rise <= least:
                    continue
                if crowded:
                    if rise < highest + level:
                        continue
                elif not _is_peak(lit, unlit, region, i, j, rise):
                    continue
                if mask.size > 0 and mask[j, i] == 0:
                    continue
                height = rise - _level_at(levels, i - x0, j - y0)
                if height <= threshold * noises[ty, tx]:
                    continue
                if count < peaks.shape[0]:
                    peaks[count, 0], peaks[count, 1], peaks[count, 2] = i, j, height
                count += 1
                if crowded:
                    break
    return count, strongest


@kernel
def _level_at(levels: Array, x: float, y: float) -> float:
    """Return the level at a place, px from the first tile, between the tiles' middles."""
    down, across = levels.shape
    v, u = y / TILE - 0.5, x / TILE - 0.5
    top, left = max(min(int(v), down - 2), 0), max(min(int(u), across - 2), 0)
    under, beside = min(top + 1, down - 1), min(left + 1, across - 1)
    v, u = v - top, u - left
    upper = levels[top, left] + u * (levels[top, beside] - levels[top, left])
    lower = levels[under, left] + u * (levels[under, beside] - levels[under, left])
    return upper + v * (lower - upper)


@kernel
def _lowest_level(levels: Array, tx: int, ty: int) -> float:
    """Return the least level at the four corners of a tile."""
    lowest = levels[ty, tx]
    for y in (ty, ty + 1):
        for x in (tx, tx + 1):
            lowest = min(lowest, _level_at(levels, float(x * TILE), float(y * TILE)))
    return lowest


@kernel
def _brightest_square(
    lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int], mask: NDArray[np.uint8]
) -> tuple[int, int, float]:
    """Return the middle of the 3 x 3 pixels that rose most, and their mean rise, DN."""
    x0, y0, x1, y1 = region
    width = x1 - x0
    columns = np.zeros((3, width), np.int32)  # sums of a row, three rows in turn
    best = np.int32(-(2**30))
    column, row = x0, y0
    for j in range(y0, y1):
        a, b = lit[j, x0:x1], unlit[j, x0:x1]
        sums = columns[j % 3]
        for i in range(1, width - 1):
            sums[i] = (
                np.int32(a[i - 1]) - np.int32(b[i - 1])
                + np.int32(a[i]) - np.int32(b[i])
                + np.int32(a[i + 1]) - np.int32(b[i + 1])
            )
        if j < y0 + 2:
            continue
        for i in range(1, width - 1):
            total = columns[0, i] + columns[1, i] + columns[2, i]
            if total > best and (mask.size == 0 or mask[j - 1, x0 + i] != 0):
                best, column, row = total, x0 + i, j - 1
    return column, row, best / 9.0


@kernel
def _greatest_rise(a: Pixels, b: Pixels, left: int, right: int) -> int:
    """Return the maximum of a - b from left to right, 0 where all is negative."""
    # In the type of the pixels: it is as many times faster as they are narrower than an int.
    zero = a.dtype.type(0)
    highest = zero
    for i in range(np.uint64(left), np.uint64(right)):
        highest = max(highest, a.dtype.type(max(a[i], b[i]) - b[i]))
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
    return max(total / (right - left), 0.0) if above > BAND * (right - left) else 0.0


@kernel
def _is_peak(
    lit: Pixels, unlit: Pixels, region: tuple[int, int, int, int], i: int, j: int, rise: float
) -> bool:
    """Tell whether no neighbour exceeds a pixel; of equal ones the first is the peak."""
    for v in range(max(j - 1, region[1]), min(j + 2, region[3])):
        for u in range(max(i - 1, region[0]), min(i + 2, region[2])):
            other = float(np.int32(lit[v, u]) - np.int32(unlit[v, u]))
            if other > rise or (other == rise and (v < j or (v == j and u < i))):
                return False
    return True


@kernel
def _on_flank(table: Array, column: int, row: int, height: float) -> bool:
    """Tell whether a peak lies on a blob that was measured, or in its wings."""
    for k in range(table.shape[0]):
        dx, dy = column - table[k, 0], row - table[k, 1]
        q = np.sqrt(_distance2(dx, dy, table[k, 2], table[k, 3], table[k, 6]))
        if q < FLANK:
            return True
        outside = np.sqrt(dx * dx + dy * dy) * (1.0 - FLANK / q)
        if outside < FLANK and height < WING * table[k, 11]:
            return True
    return False


@kernel
def _wandered(
    table: Array,
    blob: tuple[float, float, float, float, float, float, float, float, float],
    column: int,
    row: int,
) -> bool:
    """Tell whether what was measured is not at its peak, or is a blob that was measured before."""
    x, y, sigma_x, sigma_y, _, _, correlation, _, _ = blob
    margin = 1.0 / min(sigma_x, sigma_y)
    away = np.sqrt(_distance2(column - x, row - y, sigma_x, sigma_y, correlation))
    if away > WINDOW + margin:
        return True
    for k in range(table.shape[0]):
        dx, dy = x - table[k, 0], y - table[k, 1]
        if _distance2(dx, dy, table[k, 2], table[k, 3], table[k, 6]) < 1.0:
            return True
    return False


@kernel
def _distance2(dx: float, dy: float, sigma_x: float, sigma_y: float, correlation: float) -> float:
    """Return the squared Mahalanobis distance."""
    u, v = dx / sigma_x, dy / sigma_y
    return (u * u - 2.0 * correlation * u * v + v * v) / (1.0 - correlation * correlation)


@kernel
def _describe(
    out: Array,
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    saturation: int,
    alone: bool,
    blob: tuple[float, float, float, float, float, float, float, float, float],
    column: int,
    row: int,
    noise: float,
    height: float,
) -> None:
    """Write one row of the table."""
    x, y, sigma_x, sigma_y, _, _, correlation, _, level = blob
    half_x, half_y = max(WINDOW * sigma_x, 3.0), max(WINDOW * sigma_y, 3.0)
    left, right = max(int(x - half_x), region[0]), min(int(x + half_x) + 2, region[2])
    top, bottom = max(int(y - half_y), region[1]), min(int(y + half_y) + 2, region[3])
    norm = flux = stood = around = squares = 0.0
    outside = 0
    clipped = False
    weights = np.empty((bottom - top, right - left))
    step = 1 + int(max(half_x, half_y) / (SAMPLES + 1))
    for j in range(top, bottom, step):
        for i in range(left, right, step):
            q = _distance2(i - x, j - y, sigma_x, sigma_y, correlation)
            w = np.exp(-0.5 * q)
            weights[j - top, i - left] = w
            under = float(unlit[j, i])
            clipped = clipped or unlit[j, i] >= saturation
            if q > WINDOW * WINDOW:
                around += under
                squares += under * under
                outside += 1
            elif lit[j, i] < saturation:
                norm += w * w
                flux += w * (float(lit[j, i]) - under - level)
    amplitude = flux / norm if norm > 0.0 else height
    around = around / outside if outside > 0 else 0.0
    texture = np.sqrt(max(squares / outside - around * around, 0.0)) if outside > 0 else 0.0
    misfit, count = 0.0, 0
    total = 0.0
    for j in range(top, bottom, step):
        for i in range(left, right, step):
            w = weights[j - top, i - left]
            stood += w * (float(unlit[j, i]) - around)
            total += w * w
            if lit[j, i] < saturation:
                left_over = float(lit[j, i]) - float(unlit[j, i]) - level - amplitude * w
                misfit += left_over * left_over
                count += 1
    # Less what the noise explains, and five of its standard deviations: it is known to 10 % only.
    misfit -= (count + 5.0 * np.sqrt(2.0 * count)) * noise * noise
    explained = amplitude * amplitude * norm
    out[0:9] = blob
    out[9], out[10], out[11] = column, row, height
    out[12] = amplitude
    out[13] = np.sqrt(max(misfit, 0.0) / explained) if explained > 0.0 else 0.0
    out[14] = _beside(lit, unlit, region, column, row, level) / max(height, noise)
    # In one frame by itself nothing fell: what is darker beside it is the scene.
    out[15] = 0.0
    if not alone:
        size = 2.0 * min(sigma_x, sigma_y)
        out[15] = _fall(lit, unlit, region, x, y, 3.0 * half_x, 3.0 * half_y, size, level)
    out[16] = stood / total if total > 0.0 else 0.0
    out[17] = texture
    out[18] = clipped
    out[19] = noise
    out[20] = _unrest(lit, unlit, region, x, y, half_x, half_y, level)


@kernel
def _beside(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    column: int,
    row: int,
    level: float,
) -> float:
    """Return the mean rise of the four neighbours of a pixel, DN; their own where at the edge."""
    total, count = 0.0, 0
    for u, v in ((column - 1, row), (column + 1, row), (column, row - 1), (column, row + 1)):
        if region[0] <= u < region[2] and region[1] <= v < region[3]:
            total += float(lit[v, u]) - float(unlit[v, u]) - level
            count += 1
    return total / count if count > 0 else 0.0


@kernel
def _fall(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    x: float,
    y: float,
    half_x: float,
    half_y: float,
    size: float,
    level: float,
) -> float:
    """
    Return the greatest fall below the level near a place, DN.

    It is the mean over a square of the blob's size, 2 x 2 px at least: what moved away was as
    large as what came, and a pixel may be hot. Of wide blobs not every pixel is looked at.
    """
    left, right = max(int(x - half_x), region[0]), min(int(x + half_x) + 1, region[2])
    top, bottom = max(int(y - half_y), region[1]), min(int(y + half_y) + 1, region[3])
    step = 1 + int(max(half_x, half_y) / (3 * SAMPLES + 1))
    side = max(int(size / step), 2)
    width = (right - left + step - 1) // step
    columns = np.zeros(width, np.int32)  # sums over the last rows, as many as the square has
    lowest = np.int32(2**30)
    row = 0
    for j in range(top, bottom, step):
        _add_row(columns, lit[j], unlit[j], left, step, 1)
        if row >= side:
            before = j - side * step
            _add_row(columns, lit[before], unlit[before], left, step, -1)
        row += 1
        if row < side:
            continue
        total = np.int32(0)
        for i in range(width):
            total += columns[i]
            if i >= side:
                total -= columns[i - side]
            if i >= side - 1:
                lowest = min(lowest, total)
    return max(level - lowest / (side * side), 0.0) if lowest < 2**30 else 0.0


@kernel
def _add_row(
    columns: NDArray[np.int32], a: Pixels, b: Pixels, left: int, step: int, sign: int
) -> None:
    """Add a row of a - b, or take it away, every so many pixels."""
    for i in range(np.uint64(columns.size)):
        k = np.uint64(left) + i * np.uint64(step)
        columns[i] += np.int32(sign * (np.int32(a[k]) - np.int32(b[k])))


@kernel
def _unrest(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    x: float,
    y: float,
    half_x: float,
    half_y: float,
    level: float,
) -> float:
    """
    Return the standard deviation of lit less unlit about a blob, DN.

    It is that of the rows of a box three times as large, without the box itself, and of the rows
    the median: another light is on few of them.
    """
    left, right = max(int(x - 3.0 * half_x), region[0]), min(int(x + 3.0 * half_x) + 1, region[2])
    top, bottom = max(int(y - 3.0 * half_y), region[1]), min(int(y + 3.0 * half_y) + 1, region[3])
    first, last = max(int(x - half_x), left), min(int(x + half_x) + 2, right)
    step = 1 + int(half_y / (SAMPLES + 1))
    rows = np.empty((bottom - top + step - 1) // step)
    count = 0
    middle = np.float32(level)
    for j in range(top, bottom, step):
        inside = abs(j - y) <= half_y
        size = right - left - (last - first if inside else 0)
        if size <= 0:
            continue
        a, b = lit[j], unlit[j]
        total = _departure(a, b, left, first if inside else right, middle)
        if inside:
            total += _departure(a, b, last, right, middle)
        rows[count] = total / size
        count += 1
    return FROM_MEAN * median(rows, count) if count > 0 else 0.0


@kernel
def _departure(a: Pixels, b: Pixels, left: int, right: int, level: float) -> float:
    """Return the sum of |a - b - level| from left to right."""
    total = np.float32(0.0)
    for i in range(np.uint64(left), np.uint64(right)):
        total += abs(np.float32(np.int32(a[i]) - np.int32(b[i])) - level)
    return float(total)

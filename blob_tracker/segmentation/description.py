"""What tells a blob from other things that lit up: a row of numbers for each."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.flanks import flank_misfit
from blob_tracker.segmentation.gaussian_values import gaussian_values
from blob_tracker.segmentation.gaussian_weights import VECTOR
from blob_tracker.segmentation.order_statistics import fill_ranks
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

FIELDS = 22  # of a candidate
WINDOW_SIGMA = 3.0  # sigma to either side: what is compared with a Gaussian
SIGMA_PER_MEAN_DEVIATION = np.sqrt(0.5 * np.pi)  # sigma over the mean |d| of a Gaussian deviate
SHARPEST_RING_PX, ROUNDEST_RING = 2.5, 1.3  # px of sigma, and times as long as wide
SAMPLES = 12  # to either side of a blob on which it is compared; of wider ones pixels are left out


@kernel
def distance2(dx: float, dy: float, sigma_x: float, sigma_y: float, correlation: float) -> float:
    """Return the squared Mahalanobis distance."""
    u, v = dx / sigma_x, dy / sigma_y
    return (u * u - 2.0 * correlation * u * v + v * v) / (1.0 - correlation * correlation)


@kernel
def describe(
    out: Array,
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    saturation: int,
    single_frame: bool,
    blob: tuple[float, float, float, float, float, float, float, float, float],
    column: int,
    row: int,
    noise: float,
    height: float,
    streak: bool,
) -> None:
    """
    Write one row of the table: the fields of `Candidate` in their order.

    Parameters
    ----------
    out : (22,) array
        The row.
    lit, unlit : (h, w) arrays
        DN, C-contiguous, of one type.
    region : (int, int, int, int)
        Columns x0 to x1 and rows y0 to y1 that may be looked at, px.
    saturation : int
        The DN at which a pixel is clipped.
    single_frame : bool
        Whether nothing was subtracted.
    blob : tuple of 9 floats
        What `adaptive_moments.measure` returns.
    column, row : int
        Pixel of the peak.
    noise, height : float
        Standard deviation of lit less unlit and height of that pixel, DN.
    streak : bool
        Whether it is an even line with two ends.

    """
    x, y, sigma_x, sigma_y, major, minor, correlation, _, level = blob
    half_x, half_y = max(WINDOW_SIGMA * sigma_x, 3.0), max(WINDOW_SIGMA * sigma_y, 3.0)
    left, right = max(int(x - half_x), region[0]), min(int(x + half_x) + 2, region[2])
    top, bottom = max(int(y - half_y), region[1]), min(int(y + half_y) + 2, region[3])
    norm = flux = unlit_amplitude = surround_level = squares = 0.0
    outside = 0
    clipped, overexposed = False, False
    step = 1 + int(max(half_x, half_y) / (SAMPLES + 1))
    down, across = (bottom - top + step - 1) // step, (right - left + step - 1) // step
    distances2 = np.empty((down, across))
    for b in range(down):
        for a in range(across):
            distances2[b, a] = distance2(
                left + a * step - x, top + b * step - y, sigma_x, sigma_y, correlation
            )
    weights = gaussian_values(distances2)
    for b in range(down):
        for a in range(across):
            j, i = top + b * step, left + a * step
            q, w = distances2[b, a], weights[b, a]
            unlit_pixel = float(unlit[j, i])
            if unlit[j, i] >= saturation:
                # One by itself is stuck, and tells nothing of the scene.
                clipped = clipped or not _is_single(unlit, region, i, j, saturation)
                continue
            overexposed = overexposed or lit[j, i] >= saturation
            if q > WINDOW_SIGMA * WINDOW_SIGMA:
                surround_level += unlit_pixel
                squares += unlit_pixel * unlit_pixel
                outside += 1
            elif lit[j, i] < saturation:
                norm += w * w
                flux += w * (float(lit[j, i]) - unlit_pixel - level)
    amplitude = flux / norm if norm > 0.0 else height
    surround_level = surround_level / outside if outside > 0 else 0.0
    variance = squares / outside - surround_level * surround_level if outside > 0 else 0.0
    texture = np.sqrt(max(variance, 0.0))
    misfit, count, deepest = 0.0, 0, 0.0
    total = 0.0
    for b in range(down):
        for a in range(across):
            j, i, w = top + b * step, left + a * step, weights[b, a]
            if unlit[j, i] >= saturation:
                continue
            unlit_amplitude += w * (float(unlit[j, i]) - surround_level)
            total += w * w
            if lit[j, i] < saturation:
                residual = float(lit[j, i]) - float(unlit[j, i]) - level - amplitude * w
                misfit += residual * residual
                deepest = min(deepest, residual)
                count += 1
    misfit -= deepest * deepest  # a dead pixel does not see the light
    # Less what the noise explains, and five of its standard deviations: it is known to 10 % only.
    misfit -= (count + 5.0 * np.sqrt(2.0 * count)) * noise * noise
    explained = amplitude * amplitude * norm
    misfit = np.sqrt(max(misfit, 0.0) / explained) if explained > 0.0 else 0.0
    if overexposed and misfit > 0.0:
        # The Gaussian of the flat top is too wide for the flanks, which tell the true one.
        steeper, peak = flank_misfit(
            lit, unlit, (left, top, right, bottom), step, x, y, level, noise, saturation
        )
        if steeper < misfit:
            misfit, amplitude = steeper, peak
    out[0:9] = blob
    out[9], out[10], out[11] = column, row, height
    out[12] = amplitude
    out[13] = misfit
    if minor > SHARPEST_RING_PX and major < ROUNDEST_RING * minor and explained > 0.0:
        # A light out of focus is a disc or a ring: round, but no Gaussian.
        left_over = _round_misfit(lit, unlit, region, saturation, x, y, half_x, level)
        out[13] = min(out[13], left_over)
    out[14] = _neighbour_rise(lit, unlit, region, column, row, level) / max(height, noise)
    # In one frame by itself nothing fell: what is darker beside it is the scene.
    out[15] = 0.0
    if not single_frame:
        size = 2.0 * min(sigma_x, sigma_y)
        out[15] = _fall(lit, unlit, region, x, y, 3.0 * half_x, 3.0 * half_y, size, level)
    out[16] = unlit_amplitude / total if total > 0.0 else 0.0
    out[17] = texture
    out[18] = clipped
    out[19] = noise
    out[20] = _surround_noise(lit, unlit, region, x, y, half_x, half_y, level)
    out[21] = streak


@kernel
def _round_misfit(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    saturation: int,
    x: float,
    y: float,
    reach: float,
    level: float,
) -> float:
    """Return what the mean of each distance from a place leaves, rms over the rms of the light."""
    left, right = max(int(x - reach), region[0]), min(int(x + reach) + 2, region[2])
    top, bottom = max(int(y - reach), region[1]), min(int(y + reach) + 2, region[3])
    # Rings of a pixel, between which the level runs straight.
    size = int(reach) + 2
    sums, counts = np.zeros(size + 1), np.zeros(size + 1)
    step = 1 + int(reach / (2 * SAMPLES))
    squares, lost = 0.0, 0.0
    for turn in range(2):
        for j in range(top, bottom, step):
            for i in range(left, right, step):
                distance = np.sqrt((i - x) * (i - x) + (j - y) * (j - y))
                inner = int(distance)
                if inner >= size or lit[j, i] >= saturation:
                    continue
                outer_part = distance - inner
                value = float(lit[j, i]) - float(unlit[j, i]) - level
                if turn == 0:
                    sums[inner] += (1.0 - outer_part) * value
                    counts[inner] += 1.0 - outer_part
                    sums[inner + 1] += outer_part * value
                    counts[inner + 1] += outer_part
                else:
                    mean = (1.0 - outer_part) * sums[inner] + outer_part * sums[inner + 1]
                    squares += value * value
                    lost += (value - mean) * (value - mean)
        if turn == 0:
            for k in range(size + 1):
                sums[k] /= max(counts[k], 1e-9)
    return np.sqrt(lost / max(squares, 1e-9))


@kernel
def _is_single(
    image: Pixels, region: tuple[int, int, int, int], column: int, row: int, saturation: int
) -> bool:
    """Tell whether none of a clipped pixel's neighbours is clipped."""
    for v in range(max(row - 1, region[1]), min(row + 2, region[3])):
        for u in range(max(column - 1, region[0]), min(column + 2, region[2])):
            if (u != column or v != row) and image[v, u] >= saturation:
                return False
    return True


@kernel
def _neighbour_rise(
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
    across, down = (right - left + step - 1) // step, (bottom - top + step - 1) // step
    if min(across, down) < side:
        return 0.0
    # Indices that cannot be negative, and one plain loop a sum: what the compiler vectorizes.
    rises = np.empty((down, across), np.int32)
    for v in range(np.uint64(down)):
        _fill_row(rises, v, lit, unlit, np.uint64(top) + v * np.uint64(step), left, step)
    squares = np.empty(across - side + 1, np.int32)
    lowest = np.int32(2**30)
    for v in range(np.uint64(down - side + 1)):
        for k in range(np.uint64(1), np.uint64(side)):
            for u in range(np.uint64(across)):
                rises[v, u] += rises[v + k, u]
        for u in range(np.uint64(squares.size)):
            squares[u] = rises[v, u]
        for k in range(np.uint64(1), np.uint64(side)):
            for u in range(np.uint64(squares.size)):
                squares[u] += rises[v, u + k]
        for u in range(np.uint64(squares.size)):
            lowest = min(lowest, squares[u])
    return max(level - lowest / (side * side), 0.0)


@kernel
def _fill_row(
    rises: NDArray[np.int32], v: int, lit: Pixels, unlit: Pixels, j: int, left: int, step: int
) -> None:
    """Fill in row v with row j of lit less unlit, every so many pixels."""
    if step == 1:
        for u in range(np.uint64(rises.shape[1])):
            i = np.uint64(left) + u
            rises[v, u] = np.int32(lit[j, i]) - np.int32(unlit[j, i])
    else:
        for u in range(np.uint64(rises.shape[1])):
            i = np.uint64(left) + u * np.uint64(step)
            rises[v, u] = np.int32(lit[j, i]) - np.int32(unlit[j, i])


@kernel
def _surround_noise(
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
    # Whole vectors, where the frame is as wide: pixels that are not asked for have no weight.
    across = min((right - left + VECTOR - 1) // VECTOR * VECTOR, lit.shape[1])
    begin = min(left, lit.shape[1] - across)
    weights = np.zeros((2, across), np.float32)  # of a row above the blob or below it, beside it
    weights[:, left - begin:right - begin] = np.float32(1.0)
    weights[1, first - begin:last - begin] = np.float32(0.0)
    count = 0
    middle = np.float32(level)
    for j in range(top, bottom, step):
        inside = abs(j - y) <= half_y
        size = right - left - (last - first if inside else 0)
        if size <= 0:
            continue
        rows[count] = _absolute_deviation(
            lit[j], unlit[j], begin, weights[1 if inside else 0], middle
        ) / size
        count += 1
    if count == 0:
        return 0.0
    middle_two = np.empty(2)
    fill_ranks(rows[:count], ((count - 1) // 2, count // 2), middle_two)
    return SIGMA_PER_MEAN_DEVIATION * 0.5 * (middle_two[0] + middle_two[1])


@kernel
def _absolute_deviation(
    a: Pixels, b: Pixels, begin: int, weights: NDArray[np.float32], level: float
) -> float:
    """Return the sum of |a - b - level| with these weights, from a pixel on."""
    total = np.float32(0.0)
    first = np.uint64(begin)
    for i in range(np.uint64(weights.size)):
        k = first + i
        total += weights[i] * abs(np.float32(np.int32(a[k]) - np.int32(b[k])) - level)
    return float(total)

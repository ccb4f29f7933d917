"""Place, width and SNR of the blob at a peak, by adaptive moments."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.gaussian_weights import fill_weights, VECTOR
from blob_tracker.segmentation.order_statistics import fill_ranks
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

REACH_SIGMA = 4.0  # sigma: a Gaussian is 3e-4 of its peak there, which is background
FINEST_SCALE_PX = 0.7  # px, scale at which the search begins: the pixel itself is 0.29 wide
COARSEST_SCALE_PX = 8.0  # binned px; beyond it the pixels are binned and the search goes on
BINNING = 4  # by which they are: from 8 px to 2, well sampled still
# Binned px to either side: first what holds the finest scales, because most peaks are noise.
HALF_WIDTHS_PX = (6, 12, int(REACH_SIGMA * COARSEST_SCALE_PX))
MAX_STEPS = 20  # the moments settle in 3 to 6
CONVERGED_SIGMA = 0.02  # change of sigma and of place, in sigma, at which they have
# Of the weight's variance: what has more of it along one axis and less across is four times as
# long as wide, or longer: no blob, and a weight that grew with it would only gather what is near.
LINE_ALONG, LINE_ACROSS = 0.8, 0.2
LINE_SIGMA_PX = 1.9  # px of the weight: below it pixels and noise have a part in what is long
# Of a blob's response against its own surroundings: where a filter of twice the scale has no more
# than so many times it, the blob is the narrow one (that of a Gaussian 1.6 times as wide grows by
# this much), and what is wider is a glow that it stands on.
SHARP_GROWTH = 1.15
SHARP_LIMIT = 1.9  # times the scale of that blob, which its sigma is not beyond
# Pixels on a circle of 4 s: enough for a median and quartiles, and where these are when sorted.
CIRCLE = 24
RANKS = (CIRCLE // 4, (CIRCLE - 1) // 2, CIRCLE // 2, 3 * CIRCLE // 4)
COSINES = np.cos(2.0 * np.pi * np.arange(CIRCLE) / CIRCLE)
SINES = np.sin(2.0 * np.pi * np.arange(CIRCLE) / CIRCLE)
SIGMA_PER_QUARTILES = 0.741  # sigma over the distance of the quartiles of Gaussian deviates
RING_UPDATE_SIGMA = 0.15  # change of sigma, in sigma, after which the background is taken anew
WIDEST = 2 * HALF_WIDTHS_PX[-1] + 1 + VECTOR  # binned px of a patch, with what is weighted by 0

# What `measure` returns: the SNR is 0 if there is no blob.
Measured = tuple[float, float, float, float, float, float, float, float, float]
NO_BLOB = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Scratch(NamedTuple):
    """
    Memory that `measure` writes to, for one peak after the other.

    Parameters
    ----------
    pixels : (n, n) float32 array
        Lit less unlit about the peak.
    along, across : two (3, n) arrays
        Weights of columns and rows, the same times the distance and its square.
    ring : (n,) float32 array
        Pixels about the blob.
    ranked : (4,) array
        Some of them.

    """

    pixels: NDArray[np.float32]
    along: Array
    across: Array
    ring: NDArray[np.float32]
    ranked: Array


@kernel
def scratch() -> Scratch:
    """Return such memory, which is enough for any blob."""
    return Scratch(
        np.empty((WIDEST, WIDEST), np.float32), np.empty((3, WIDEST)), np.empty((3, WIDEST)),
        np.empty(4 * WIDEST, np.float32), np.empty(len(RANKS)),
    )


@kernel
def measure(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    column: int,
    row: int,
    level: float,
    noise: float,
    min_snr: float,
    max_sigma: float,
    memory: Scratch,
) -> Measured:
    """
    Measure the blob at a peak.

    First the scale s is doubled from 0.7 px for as long as the response of the matched filter,

        SNR(s) = sum(w I) / (noise sqrt(sum w^2)),   w = exp(-r^2 / 2 s^2),

    grows; for a Gaussian blob its maximum is at s = sigma. A narrow blob on a wide glow (haze, a
    wall) has a maximum of its own, against the median of the pixels at 4 s and in units of their
    scatter: there the search ends as well. Then the weighted moments are iterated
    to where the weight is the blob itself (Bernstein and Jarvis, AJ 123 (2002), section 3.1):
    with <d> and <dd> the first and second moments under w,

        c <- c + <d> (1 + s^2 / sigma^2),   1 / sigma^2 <- 1 / <dd> - 1 / s^2,   s <- sigma.

    What turns out to be a line is left as the weight sees it, with a long axis of 2 s. The
    background is the median of the pixels at 4 s. Blobs wider than about 4 px are measured on
    binned pixels, so that the time hardly depends on the width.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, of one type.
    region : (int, int, int, int)
        Columns x0 to x1 and rows y0 to y1 that may be looked at, px.
    column, row : int
        Pixel of the peak.
    level, noise : float
        Background and standard deviation of lit less unlit, DN.
    min_snr : float
        SNR below which the blob is not measured further.
    max_sigma : float
        Greatest sigma, px.
    memory : Scratch
        Is written to.

    Returns
    -------
    x, y, sigma_x, sigma_y : float
        Place and standard deviations along the rows and columns, px.
    sigma_major, sigma_minor, correlation : float
        Standard deviations along the longest and shortest axis, px; correlation of x and y.
    snr : float
        Of the matched filter, 0 where nothing stands out or it is wider than `max_sigma`.
    background : float
        Median of lit less unlit about it, DN.

    """
    x, y, sigma = float(column), float(row), FINEST_SCALE_PX
    binning, size = 1, 0
    while binning * FINEST_SCALE_PX <= max_sigma:
        half = HALF_WIDTHS_PX[size]
        coarsest = half / REACH_SIGMA
        x0 = max(int(round(x)) - half * binning, region[0])
        y0 = max(int(round(y)) - half * binning, region[1])
        width = (min(int(round(x)) + (half + 1) * binning, region[2]) - x0) // binning
        height = (min(int(round(y)) + (half + 1) * binning, region[3]) - y0) // binning
        if min(width, height) < 3:
            return NO_BLOB
        # The centre of the samples of a binned pixel is so far from the first one.
        edge = 0.5 * (binning - max(binning // BINNING, 1))
        _fill_patch(memory.pixels, lit, unlit, x0, y0, width, height, binning)
        found = _iterate(
            memory,
            width,
            height,
            (x - x0 - edge) / binning,
            (y - y0 - edge) / binning,
            sigma / binning,
            level,
            noise / min(binning, BINNING),
            min_snr,
            coarsest,
        )
        snr, too_wide = found[7], found[2] >= coarsest
        if snr < min_snr and not too_wide:
            return NO_BLOB
        x, y = x0 + edge + binning * found[0], y0 + edge + binning * found[1]
        if not too_wide:
            # What a binned pixel is wide is no part of the blob; nor does its filter see less.
            sigma_x, sigma_y, major, minor = (
                _unbinned(found[2], binning), _unbinned(found[3], binning),
                _unbinned(found[4], binning), _unbinned(found[5], binning),
            )
            snr *= max(binning // BINNING, 1)
            inside = region[0] <= x <= region[2] - 1 and region[1] <= y <= region[3] - 1
            if not inside or max(sigma_x, sigma_y) > max_sigma:
                return NO_BLOB
            return (
                x, y, sigma_x, sigma_y, major, minor, found[6], snr, found[8],
            )
        sigma = 0.5 * coarsest * binning
        if size + 1 < len(HALF_WIDTHS_PX):
            size += 1
        else:
            binning *= BINNING
    return NO_BLOB


@kernel
def _unbinned(sigma: float, binning: int) -> float:
    """Return a sigma in px of one that was measured in binned pixels."""
    return np.sqrt(max((binning * sigma) ** 2 - (binning * binning - 1) / 12.0, 1.0 / 12.0))


@kernel
def _fill_patch(
    patch: NDArray[np.float32], lit: Pixels, unlit: Pixels, x0: int, y0: int, width: int,
    height: int, binning: int,
) -> None:
    """Fill in (height, width) means of lit less unlit over squares, of 4 x 4 of their pixels."""
    if binning == 1:
        # As many as fill whole vectors, where the frame has them.
        padded = min((width + VECTOR - 1) // VECTOR * VECTOR, lit.shape[1] - x0)
        for j in range(height):
            out, a, b = patch[j], lit[y0 + j], unlit[y0 + j]
            for i in range(np.uint64(padded)):
                k = np.uint64(x0) + i
                out[i] = np.float32(np.int32(a[k]) - np.int32(b[k]))
            for i in range(np.uint64(VECTOR)):  # what is beyond is weighted by 0
                out[np.uint64(width) + i] = np.float32(0.0)
        return
    step = max(binning // BINNING, 1)
    for j in range(height):
        out = patch[j]
        for i in range(np.uint64(width + VECTOR)):
            out[i] = np.float32(0.0)
        for v in range(y0 + j * binning, y0 + (j + 1) * binning, step):
            a, b = lit[v], unlit[v]
            for i in range(width):
                for u in range(x0 + i * binning, x0 + (i + 1) * binning, step):
                    out[i] += np.float32(np.int32(a[u]) - np.int32(b[u]))
        for i in range(np.uint64(width)):
            out[i] /= np.float32(BINNING * BINNING)


@kernel
def _iterate(
    memory: Scratch,
    width: int,
    height: int,
    x: float,
    y: float,
    sigma: float,
    level: float,
    noise: float,
    min_snr: float,
    coarsest: float,
) -> Measured:
    """
    Return what `measure` does, in px of the patch of (height, width) in the memory.

    Sigma is `coarsest` or more where the blob is wider than that; the SNR is below `min_snr`, and
    what else is returned is rough, if there is none.
    """
    best = -1.0
    scale = sigma
    limit = np.inf
    sharpest = sharp_scale = sharp_x = sharp_y = 0.0
    while scale <= coarsest:
        at_x, at_y = x, y
        flux, norm, dx, dy, mxx, myy, mxy = _moments(memory, width, height, x, y, scale, level)
        snr = flux / (noise * np.sqrt(norm))
        if snr >= min_snr:
            around, spread = _surroundings(memory, width, height, x, y, scale)
            # The sum of w is twice that of its square.
            own = (flux - 2.0 * norm * (around - level)) / (max(noise, spread) * np.sqrt(norm))
            if sharpest >= min_snr and own < SHARP_GROWTH * sharpest:
                sigma, limit, x, y = sharp_scale, SHARP_LIMIT * sharp_scale, sharp_x, sharp_y
                break
            if own > sharpest:
                sharpest, sharp_scale, sharp_x, sharp_y = own, scale, at_x, at_y
        if snr <= best:
            break
        best, sigma = snr, scale
        if flux > 0.0:
            x += min(max(dx, -scale), scale)
            y += min(max(dy, -scale), scale)
        if _is_line(mxx, myy, mxy, scale):
            break
        scale *= 2.0
    if scale > coarsest and best > 0.0:
        return x, y, coarsest, coarsest, coarsest, coarsest, 0.0, best, level
    if best < 0.8 * min_snr:  # the scales tried are within 20 % of the best one
        return x, y, sigma, sigma, sigma, sigma, 0.0, 0.0, level
    xx = yy = sigma * sigma
    mxx = myy = 0.5 * xx
    mxy = 0.0
    weight = xx
    ring_sigma = 0.0
    for _ in range(MAX_STEPS):
        if abs(sigma - ring_sigma) > RING_UPDATE_SIGMA * sigma:
            level = _ring_median(memory, width, height, x, y, sigma)
            ring_sigma = sigma
        flux, norm, dx, dy, mxx, myy, mxy = _moments(memory, width, height, x, y, sigma, level)
        best = flux / (noise * np.sqrt(norm))
        if best <= 0.0:
            return x, y, sigma, sigma, sigma, sigma, 0.0, 0.0, level
        weight = sigma * sigma
        if _is_line(mxx, myy, mxy, sigma):
            xx, yy = _unweighted(mxx, weight), _unweighted(myy, weight)
            break
        # A step is at most a doubling: what the moments say far from the blob is not exact.
        xx = _unweighted(mxx, weight)
        yy = _unweighted(myy, weight)
        new = np.sqrt(0.5 * (xx + yy))
        gain = 1.0 + weight / (new * new)
        dx = min(max(gain * dx, -sigma), sigma)
        dy = min(max(gain * dy, -sigma), sigma)
        x += dx
        y += dy
        new = min(new, limit)
        change = max(abs(new - sigma), abs(dx), abs(dy))
        sigma = new
        if sigma >= coarsest or change < CONVERGED_SIGMA * sigma:
            break
    if sigma >= coarsest:
        return x, y, coarsest, coarsest, coarsest, coarsest, 0.0, best, level
    mean, half = 0.5 * (mxx + myy), np.sqrt(0.25 * (mxx - myy) ** 2 + mxy * mxy)
    major, minor = _unweighted(mean + half, weight), _unweighted(mean - half, weight)
    middle, apart = 0.5 * (major + minor), 0.5 * (major - minor)
    xx = yy = middle
    correlation = 0.0
    if half > 0.0:
        # The axes of the blob are those of its weighted moments.
        cosine, sine = 0.5 * (mxx - myy) / half, mxy / half
        xx, yy = middle + apart * cosine, middle - apart * cosine
        correlation = apart * sine / np.sqrt(xx * yy)
    return (
        x, y, np.sqrt(xx), np.sqrt(yy), np.sqrt(major), np.sqrt(minor), correlation, best, level
    )


@kernel
def stands_out(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    column: int,
    row: int,
    noise: float,
    min_snr: float,
    memory: Scratch,
) -> bool:
    """
    Tell whether a narrow blob is at a peak that lies on something wide.

    It is where a matched filter of the finest scales has the SNR that is asked for, in units of
    the scatter about the peak: on a bright blob noise is more than in the tile.
    """
    half = HALF_WIDTHS_PX[0]
    x0, y0 = max(column - half, region[0]), max(row - half, region[1])
    x1, y1 = min(column + half + 1, region[2]), min(row + half + 1, region[3])
    # Most peaks on a wide blob are noise: four pixels tell them.
    rise = float(lit[row, column]) - float(unlit[row, column])
    about = 0.0
    for u, v in ((x0, row), (x1 - 1, row), (column, y0), (column, y1 - 1)):
        about += 0.25 * (float(lit[v, u]) - float(unlit[v, u]))
    if rise - about < 0.5 * min_snr * noise:
        return False
    width, height = x1 - x0, y1 - y0
    _fill_patch(memory.pixels, lit, unlit, x0, y0, width, height, 1)
    x, y = float(column - x0), float(row - y0)
    for scale in (FINEST_SCALE_PX, 2.0 * FINEST_SCALE_PX):
        around, spread = _surroundings(memory, width, height, x, y, scale)
        flux, norm, _, _, _, _, _ = _moments(memory, width, height, x, y, scale, around)
        if flux >= min_snr * max(noise, spread) * np.sqrt(norm):
            return True
    return False


@kernel
def _surroundings(
    memory: Scratch, width: int, height: int, x: float, y: float, scale: float
) -> tuple[float, float]:
    """Return median and scatter (as a sigma) of the pixels on a circle of 4 s about (x, y)."""
    radius = max(REACH_SIGMA * scale, 3.0)
    values = memory.ring[:CIRCLE]
    for k in range(CIRCLE):
        i = int(min(max(x + radius * COSINES[k] + 0.5, 0.0), width - 1.0))
        j = int(min(max(y + radius * SINES[k] + 0.5, 0.0), height - 1.0))
        values[k] = memory.pixels[j, i]
    fill_ranks(values, RANKS, memory.ranked)
    low, lower, upper, high = memory.ranked
    return 0.5 * (lower + upper), SIGMA_PER_QUARTILES * (high - low)


@kernel
def _is_line(mxx: float, myy: float, mxy: float, sigma: float) -> bool:
    """Tell whether the moments under a weight of that sigma are those of a line."""
    mean, half = 0.5 * (mxx + myy), np.sqrt(0.25 * (mxx - myy) ** 2 + mxy * mxy)
    weight = sigma * sigma
    return (
        sigma > LINE_SIGMA_PX
        and mean + half > LINE_ALONG * weight
        and mean - half < LINE_ACROSS * weight
    )


@kernel
def _unweighted(moment: float, weight: float) -> float:
    """Return the variance of a Gaussian whose second moment under a Gaussian weight is given."""
    if moment >= 0.8 * weight:
        return 4.0 * weight
    return max(1.0 / (1.0 / max(moment, 0.05) - 1.0 / weight), 0.25 * weight, 0.1)


@kernel
def _moments(
    memory: Scratch, width: int, height: int, x: float, y: float, sigma: float, level: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return sum(w I), sum(w^2), and the first and second moments under w about (x, y)."""
    half = max(REACH_SIGMA * sigma, 2.0)
    first, last = max(int(x - half), 0), min(int(x + half) + 2, width)
    top, bottom = max(int(y - half), 0), min(int(y + half) + 2, height)
    across, down = max(last - first, 0), max(bottom - top, 0)
    padded, norm_x = fill_weights(memory.along, across, first, x, sigma)
    _, norm_y = fill_weights(memory.across, down, top, y, sigma)
    w, w_x, w_xx = memory.along[0], memory.along[1], memory.along[2]
    v, v_y, v_yy = memory.across[0], memory.across[1], memory.across[2]
    flux = sx = sy = sxx = syy = sxy = 0.0
    for j in range(down):
        line = memory.pixels[top + j, first:]
        row = row_x = row_xx = 0.0
        for i in range(padded):
            value = line[i] - level
            row += w[i] * value
            row_x += w_x[i] * value
            row_xx += w_xx[i] * value
        flux += v[j] * row
        sx += v[j] * row_x
        sxx += v[j] * row_xx
        sy += v_y[j] * row
        syy += v_yy[j] * row
        sxy += v_y[j] * row_x
    norm = norm_x * norm_y
    if flux <= 0.0 or norm <= 0.0:
        return flux, max(norm, 1e-12), 0.0, 0.0, 0.0, 0.0, 0.0
    sx /= flux
    sy /= flux
    return flux, norm, sx, sy, sxx / flux, syy / flux, sxy / flux


@kernel
def _ring_median(
    memory: Scratch, width: int, height: int, x: float, y: float, sigma: float
) -> float:
    """Return the median of the pixels on the border of the box of 4 sigma about (x, y)."""
    half = max(REACH_SIGMA * sigma, 3.0)
    left, right = max(int(x - half), 0), min(int(x + half) + 1, width - 1)
    top, bottom = max(int(y - half), 0), min(int(y + half) + 1, height - 1)
    pixels, ring = memory.pixels, memory.ring
    count = 0
    for i in range(left, right + 1):
        ring[count] = pixels[top, i]
        ring[count + 1] = pixels[bottom, i]
        count += 2
    for j in range(top + 1, bottom):
        ring[count] = pixels[j, left]
        ring[count + 1] = pixels[j, right]
        count += 2
    fill_ranks(ring[:count], ((count - 1) // 2, count // 2), memory.ranked)
    return 0.5 * (memory.ranked[0] + memory.ranked[1])

"""Every peak in a part of a frame, measured and described: the loops over pixels."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.adaptive_moments import measure, scratch, stands_out
from blob_tracker.segmentation.description import describe, distance2, FIELDS, WINDOW_SIGMA
from blob_tracker.segmentation.illumination import row_gains
from blob_tracker.segmentation.local_maxima import (
    brightest_square, greatest_rises, level_at, local_maxima,
)
from blob_tracker.segmentation.rejection import fault, GLOW_WIDTH_RATIO
from blob_tracker.segmentation.streak import measure_streak
from blob_tracker.segmentation.tile_noise import tile_noise, TILE_PX
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

# Of a frame; where there are more peaks only the higher ones are looked at, and of these the
# highest are measured: a field of stars has hundreds. Most frames need no more than FEW, and room
# for more would cost more time than the search.
MOST_PEAKS, FEW_PEAKS = 2048, 128
MOST_CANDIDATES, FEW_CANDIDATES = 1024, 16
FLANK_SIGMA = 4.0  # sigma of a blob within which further peaks are its own
# And as many px further out those that have such a part of its height: the wings of the lens, the
# ringing of a codec. What is brighter is another light beside it.
WING_FRACTION = 0.1
# Beyond (FLANK_SIGMA (1 + radius))^2 <= 2 FLANK_SIGMA^2 (1 + radius^2) there are no wings. A
# little more, so that rounding decides nothing.
WING_FACTOR, ELLIPSE_FACTOR = 2.01 * FLANK_SIGMA * FLANK_SIGMA, 1.01
LEAST_GLOW_PX = 3.0  # px of sigma, from which on a blob may be a glow that a light stands on
NEAR_AT_ONCE = 64  # blobs, of which it is asked together whether any is near
SMALL_REGION_PX = 65536  # px: a larger region is not near the prediction


@kernel
def measure_peaks(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    mask: NDArray[np.uint8],
    floor: float,
    threshold: float,
    min_snr: float,
    max_sigma: float,
    saturation: int,
    single_frame: bool,
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
        0 where the target cannot be; empty if it may be anywhere.
    floor : float
        Least noise, DN.
    threshold : float
        Least height of a peak, in standard deviations of lit less unlit.
    min_snr : float
        Least SNR in the matched filter.
    max_sigma : float
        Greatest sigma, px.
    saturation : int
        The DN at which a pixel is clipped.
    single_frame : bool
        Whether nothing was subtracted. The level is then that of the scene, tile by tile; of a
        difference it is one for the whole region.
    followed : bool
        Whether the region is that about a prediction.

    Returns
    -------
    table : (n, 23) array
        A row for each peak of at least that SNR: the fields of `Candidate` in their order, and
        its `fault`.
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
    rises = greatest_rises(lit, unlit, region)
    gains, change = row_gains(lit, unlit, y0, y1)
    levels, noises, bright = tile_noise(lit, unlit, x0, y0, x1, y1, floor)
    level = np.median(levels)
    if not single_frame:
        levels[:] = level
    capacity = FEW_PEAKS if (x1 - x0) * (y1 - y0) <= SMALL_REGION_PX else MOST_PEAKS
    peaks = np.empty((capacity, 3))
    count, strongest = local_maxima(
        lit, unlit, region, mask, levels, noises, rises, threshold, peaks
    )
    while count > capacity:
        if capacity < MOST_PEAKS:
            capacity = MOST_PEAKS
            peaks = np.empty((capacity, 3))
        else:
            threshold *= 2.0
        count, strongest = local_maxima(
            lit, unlit, region, mask, levels, noises, rises, threshold, peaks
        )
    table = np.empty((FEW_CANDIDATES, FIELDS + 1))
    circles = np.empty((3, FEW_CANDIDATES))
    memory, near = scratch(), np.empty(MOST_CANDIDATES, np.int64)
    found = 0
    for index in np.argsort(-peaks[:count, 2]):
        column, row = int(peaks[index, 0]), int(peaks[index, 1])
        noise, local_level = _surroundings(levels, noises, column - x0, row - y0)
        narrowest = _on_flank(table, circles, found, column, row, peaks[index, 2], near)
        if narrowest > 0.0 and (
            narrowest < LEAST_GLOW_PX
            or not stands_out(lit, unlit, region, column, row, noise, min_snr, memory)
        ):
            continue
        blob = measure(
            lit, unlit, region, column, row, local_level, noise, min_snr, max_sigma, memory
        )
        if blob[7] < min_snr:
            continue
        streak, blob = measure_streak(lit, unlit, region, saturation, blob)
        # A faint peak in the reach of a brighter light ends in it, or half-way to it.
        # On a glow only what is far narrower is another light.
        if not (narrowest > 0.0 and GLOW_WIDTH_RATIO * blob[4] > narrowest) and not _is_misplaced(
            table, circles, found, blob, column, row, near
        ):
            describe(
                table[found], lit, unlit, region, saturation, single_frame, blob, column, row,
                noise, peaks[index, 2], streak,
            )
            circles[0, found], circles[1, found] = blob[0], blob[1]
            circles[2, found] = blob[2] * blob[2] + blob[3] * blob[3]
            found += 1
            if found == MOST_CANDIDATES:
                break
            if found == table.shape[0]:
                table, few = np.empty((MOST_CANDIDATES, FIELDS + 1)), table
                table[:found] = few
                circles, few = np.empty((3, MOST_CANDIDATES)), circles
                circles[:, :found] = few
    if found == 0 and followed and (x1 - x0) * (y1 - y0) <= SMALL_REGION_PX:
        # Near the prediction a faint blob is worth a second look: its brightest 3 x 3 pixels.
        column, row, height = brightest_square(lit, unlit, region, mask)
        noise, local_level = _surroundings(levels, noises, column - x0, row - y0)
        blob = measure(
            lit, unlit, region, column, row, local_level, noise, min_snr, max_sigma, memory
        )
        if blob[7] >= min_snr:
            describe(
                table[0], lit, unlit, region, saturation, single_frame, blob, column, row,
                noise, height - local_level, False,
            )
            found = 1
    for k in range(found):
        table[k, FIELDS] = fault(table[k], followed, min_snr)
    return table[:found], gains, change, level, np.median(noises), np.median(bright), strongest


@kernel
def _surroundings(levels: Array, noises: Array, x: int, y: int) -> tuple[float, float]:
    """Return noise and level at a pixel, counted from the first tile, DN."""
    ty = min(y // TILE_PX, noises.shape[0] - 1)
    tx = min(x // TILE_PX, noises.shape[1] - 1)
    return noises[ty, tx], level_at(levels, x, y)


@kernel
def _fill_near(
    circles: Array, count: int, x: float, y: float, factor: float, margin: float,
    near: NDArray[np.int64],
) -> int:
    """
    Fill in which of the blobs that were measured are near a place; return how many.

    They are those of which the middle is no further than factor (margin + radius^2), squared.
    `circles` has the middles, px, and the squares of radii, px^2, within which their ellipses of
    1 sigma lie.
    """
    xs, ys, radii = circles[0], circles[1], circles[2]
    found = 0
    for first in range(0, count, NEAR_AT_ONCE):
        last = min(first + NEAR_AT_ONCE, count)
        any_near = np.int64(0)  # counted, which goes in vectors: most are far
        for k in range(np.uint64(first), np.uint64(last)):
            dx, dy = x - xs[k], y - ys[k]
            any_near += np.int64(dx * dx + dy * dy <= factor * (margin + radii[k]))
        if any_near == 0:
            continue
        for k in range(first, last):
            dx, dy = x - xs[k], y - ys[k]
            if dx * dx + dy * dy <= factor * (margin + radii[k]):
                near[found] = k
                found += 1
    return found


@kernel
def _on_flank(
    table: Array, circles: Array, count: int, column: int, row: int, height: float,
    near: NDArray[np.int64],
) -> float:
    """
    Return how wide a blob is that was measured, and on which or in whose wings a peak lies.

    It is the narrowest one of them, and its sigma along the shortest axis, px; 0 where none is.
    """
    narrowest = 0.0
    for k in near[:_fill_near(circles, count, column, row, WING_FACTOR, 1.0, near)]:
        dx, dy = column - table[k, 0], row - table[k, 1]
        q = np.sqrt(distance2(dx, dy, table[k, 2], table[k, 3], table[k, 6]))
        outside = np.sqrt(dx * dx + dy * dy) * (1.0 - FLANK_SIGMA / q)
        in_wings = outside < FLANK_SIGMA and height < WING_FRACTION * table[k, 11]
        if q < FLANK_SIGMA or in_wings:
            narrowest = table[k, 5] if narrowest == 0.0 else min(narrowest, table[k, 5])
    return narrowest


@kernel
def _is_misplaced(
    table: Array,
    circles: Array,
    count: int,
    blob: tuple[float, float, float, float, float, float, float, float, float],
    column: int,
    row: int,
    near: NDArray[np.int64],
) -> bool:
    """Tell whether what was measured is not at its peak, or is a blob that was measured before."""
    x, y, sigma_x, sigma_y, _, _, correlation, _, _ = blob
    margin = 1.0 / min(sigma_x, sigma_y)
    away = np.sqrt(distance2(column - x, row - y, sigma_x, sigma_y, correlation))
    if away > WINDOW_SIGMA + margin:
        return True
    for k in near[:_fill_near(circles, count, x, y, ELLIPSE_FACTOR, 0.0, near)]:
        if table[k, 5] > GLOW_WIDTH_RATIO * blob[4]:
            continue  # a glow, which has its middle anywhere
        dx, dy = x - table[k, 0], y - table[k, 1]
        if distance2(dx, dy, table[k, 2], table[k, 3], table[k, 6]) < 1.0:
            return True
    return False

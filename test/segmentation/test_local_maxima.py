"""Peaks are the pixels that no neighbour exceeds, wherever in the region they are."""

from __future__ import annotations

from blob_tracker.segmentation.local_maxima import greatest_rises, local_maxima
from blob_tracker.segmentation.search import NO_MASK
from blob_tracker.segmentation.tile_noise import TILE_PX
import numpy as np
import pytest


def found(
    lit: np.ndarray, unlit: np.ndarray, region: tuple[int, int, int, int], level: float,
    mask: np.ndarray = NO_MASK,
) -> set[tuple[int, int]]:
    """Return columns and rows of the peaks 5 DN above a level."""
    x0, y0, x1, y1 = region
    tiles = max((y1 - y0) // TILE_PX, 1), max((x1 - x0) // TILE_PX, 1)
    peaks = np.empty((4096, 3))
    count, _ = local_maxima(
        lit, unlit, region, mask, np.full(tiles, level), np.ones(tiles),
        greatest_rises(lit, unlit, region), 5.0, peaks,
    )
    columns, rows, heights = peaks[:count].T
    rises = lit.astype(int) - unlit
    assert np.allclose(heights, rises[rows.astype(int), columns.astype(int)] - level)
    return set(zip(columns.astype(int).tolist(), rows.astype(int).tolist()))


def expected(
    lit: np.ndarray, unlit: np.ndarray, region: tuple[int, int, int, int], level: float
) -> set[tuple[int, int]]:
    """Return the same, one pixel after the other; of equal neighbours it is the first."""
    x0, y0, x1, y1 = region
    rises = lit.astype(int) - unlit
    return {
        (i, j) for j in range(y0, y1) for i in range(x0, x1)
        if rises[j, i] > level + 5.0 and not any(
            rises[v, u] >= rises[j, i] if (v, u) < (j, i) else rises[v, u] > rises[j, i]
            for v in range(max(j - 1, y0), min(j + 2, y1))
            for u in range(max(i - 1, x0), min(i + 2, x1)) if (v, u) != (j, i)
        )
    }


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
@pytest.mark.parametrize('region', [
    (0, 0, 300, 150), (7, 5, 263, 140), (295, 140, 300, 150), (0, 0, 1, 1), (10, 20, 11, 60),
])
@pytest.mark.parametrize('level', [0.0, 3.0, -12.0])
def test_peaks_are_those_of_a_look_at_each_pixel(
    kind: type, region: tuple[int, int, int, int], level: float
) -> None:
    """In a part of the frame, at its borders, and where the scene fell below the unlit one."""
    random = np.random.default_rng(4)
    lit = random.poisson(2.0, (150, 300)).astype(kind) + kind(20)
    unlit = np.full(lit.shape, 20 - level, kind)
    rows, columns = random.integers(0, 150, 400), random.integers(0, 300, 400)
    lit[rows, columns] += random.integers(3, 9, 400).astype(kind)  # many of them alike
    peaks = found(lit, unlit, region, level)
    assert peaks == expected(lit, unlit, region, level)
    if region[2] - region[0] > 100:
        assert len(peaks) > 50


def test_a_masked_pixel_is_no_peak() -> None:
    """Nor does another one become a peak for it."""
    lit = np.full((40, 60), 20, np.uint8)
    lit[10, 10:13] = 80, 90, 80
    lit[30, 40] = 90
    mask = np.ones(lit.shape, np.uint8)
    mask[10, 11] = 0
    assert found(lit, np.zeros_like(lit), (0, 0, 60, 40), 20.0, mask) == {(40, 30)}

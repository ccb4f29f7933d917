"""Otsu's threshold and its growing window, on pixels with a known answer."""

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.otsu import otsu_threshold, otsu_window
from blob_tracker.simulation import pixel_integrated_gaussian
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of


def test_threshold_of_two_levels_lies_between_them() -> None:
    """Half at 10 and half at 50: every level from 10 to 49 parts them; the first is taken."""
    assert otsu_threshold(np.array([10] * 8 + [50] * 8)) == 10


def test_threshold_maximises_the_variance_between_classes() -> None:
    """The level agrees with the definition, tried out for every level."""
    pixels = np.random.default_rng(3).integers(0, 60, 400)
    pixels[:80] += 90

    def between(level: int) -> float:
        low, high = pixels[pixels <= level], pixels[pixels > level]
        return low.size * high.size * (high.mean() - low.mean()) ** 2

    levels = range(pixels.min(), pixels.max())
    assert otsu_threshold(pixels) == max(levels, key=between)


def test_threshold_of_equal_pixels_is_refused() -> None:
    """There is nothing to part."""
    with pytest.raises(ValueError, match='all pixels are equal'):
        otsu_threshold(np.full(9, 7))


@pytest.mark.parametrize('sigma', [0.8, 2.0, 6.0])
def test_window_holds_the_bright_part_of_the_blob(sigma: float) -> None:
    """The box is centred on the blob and one to two sigma wide to either side."""
    rise = np.rint(200 * pixel_integrated_gaussian((120, 160), 80.0, 60.0, sigma))
    box = otsu_window(contrast_of(rise.astype(np.uint8)), candidate_at(80, 60), 64)
    assert box is not None
    assert box.x0 + box.x1 - 1 == 160
    assert box.y0 + box.y1 - 1 == 120
    # Otsu cuts a Gaussian near 0.4 of its peak, at 1.35 sigma; half a pixel of rounding.
    assert 1.0 * sigma - 0.5 <= (box.x1 - box.x0) / 2 <= 2.0 * sigma + 0.5


def test_a_second_blob_near_by_is_left_out() -> None:
    """Only what hangs together with the peak belongs to the box."""
    rise = np.zeros((40, 60), dtype=np.uint8)
    rise[18:23, 18:23] = 200
    rise[18:23, 25:28] = 150
    assert otsu_window(contrast_of(rise), candidate_at(20, 20), 32) == Box(18, 18, 23, 23)


def test_what_went_dark_is_background() -> None:
    """A deep fall near by does not move the threshold."""
    lit = np.full((40, 60), 50, dtype=np.uint8)
    unlit = lit.copy()
    lit[18:23, 18:23] = 100
    lit[18:23, 25:28] = 0
    assert otsu_window(contrast_of(lit, unlit), candidate_at(20, 20), 32) == Box(18, 18, 23, 23)


def test_brightening_without_background_is_no_blob() -> None:
    """A whole picture that brightens gives no window."""
    rise = np.full((480, 640), 30, dtype=np.uint8)
    assert otsu_window(contrast_of(rise), candidate_at(300, 200), 64) is None

"""The histogram's threshold and its three windows, on pixels with a known answer."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.histogram import histogram, histogram_threshold
from blob_tracker.segmentation.histogram_extended import histogram_extended
from blob_tracker.segmentation.histogram_shortened import histogram_shortened
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of


def levels(count: dict[int, int]) -> np.ndarray:
    """Return so many pixels of each level."""
    return np.repeat(list(count), list(count.values())).astype(float)


@pytest.mark.parametrize('count, threshold', [
    ({10: 50, 11: 20, 12: 5, 18: 3}, 12.5),  # 13 to 17 are empty
    ({10: 50, 12: 20, 17: 5, 30: 3}, 17.5),  # four empty bins are too few
    ({3: 9, 10: 50, 16: 8}, 10.5),  # a gap below the mode does not count
    ({10: 50, 12: 1, 14: 1, 30: 9}, 10.5),  # single pixels are nearly empty
])
def test_threshold_is_before_the_first_gap(count: dict[int, int], threshold: float) -> None:
    """Five empty bins, or bins of one pixel, end the background."""
    assert histogram_threshold(levels(count)) == threshold


def test_nearly_empty_grows_with_the_pixels() -> None:
    """Of 100,000 pixels, ten in a bin are a ten-thousandth."""
    tail = dict.fromkeys(range(11, 16), 10)
    assert histogram_threshold(levels({10: 100_000, **tail, 60: 500})) == 10.5
    tail = dict.fromkeys(range(11, 16), 12)
    assert histogram_threshold(levels({10: 100_000, **tail, 60: 500})) == 15.5


def test_no_gap_gives_no_threshold() -> None:
    """A histogram that ends near its mode, or never has a gap, parts nothing."""
    assert histogram_threshold(levels({10: 50, 11: 20})) is None
    assert histogram_threshold(levels(dict.fromkeys(range(40), 5))) is None


def test_coarse_bins_bridge_the_gaps_of_a_wide_noise() -> None:
    """Sixteen-bit noise leaves single levels empty; bins as wide as the noise do not."""
    noise = np.rint(np.random.default_rng(1).normal(2000, 40, 4000))
    assert histogram_threshold(noise, step=40.0) is None
    threshold = histogram_threshold(np.append(noise, [9000.0] * 20), step=40.0)
    # 4000 pixels of a Gaussian end between 3 and 4.5 sigma.
    assert threshold is not None and 2000 + 3 * 40 <= threshold <= 2000 + 4.5 * 40


def blob() -> Contrast:
    """Return a plateau of 100 with a peak at (22, 20), a foot of 5, and another blob."""
    lit = np.tile(np.array([[20, 21], [21, 20]], dtype=np.uint8), (20, 30))
    unlit = np.full_like(lit, 20)
    lit[17:24, 17:26] += 5
    lit[18:23, 18:25] = 120
    lit[20, 22] = 180
    lit[18:23, 30:33] = 150
    return contrast_of(lit, unlit)


def test_window_is_what_hangs_together_with_the_peak() -> None:
    """The foot at 5 to 6 counts and the other blob does not."""
    # Bins 0 and 1 are the background, 2 to 4 empty, 5 and 6 the foot, then the gap.
    assert histogram(blob(), candidate_at(22, 20), 16) == Box(18, 18, 25, 23)


def test_extended_window_has_n_pixels_more() -> None:
    """On each side, but for the border of the frame."""
    assert histogram_extended(blob(), candidate_at(22, 20), 16, extension=3) == Box(15, 15, 28, 26)
    assert histogram_extended(blob(), candidate_at(22, 20), 16, extension=20) == Box(0, 0, 45, 40)


def test_shortened_window_ends_one_pixel_past_the_peak() -> None:
    """Its last column is that right of the maximum; the left side stays."""
    assert histogram_shortened(blob(), candidate_at(22, 20), 16) == Box(18, 18, 24, 23)


@pytest.mark.parametrize('method', [histogram, histogram_shortened])
def test_a_slope_gives_no_window(method) -> None:
    """All levels alike have no background to part from."""
    slope = np.tile(np.arange(60, dtype=np.uint8), (40, 1))
    contrast, peak = contrast_of(slope), candidate_at(59, 20)
    assert method(contrast, peak, 64) is None
    assert histogram_extended(contrast, peak, 64, extension=2) is None

"""The window is sized and centred by the blob."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.sigma_window import sigma_window
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of, noisy_blob, searched

EVEN = contrast_of(np.zeros((400, 480), np.uint8))


def test_window_is_so_many_sigma_to_either_side() -> None:
    """Three sigma of 4.1 and 2.9 px are 13 and 9, about the blob and not about its peak."""
    blob = candidate_at(241, 200, x=243.3, y=198.6, sigma_x=4.1, sigma_y=2.9)
    box = sigma_window(EVEN, blob, 128, sigmas=3.0)
    assert box == Box(243 - 13, 199 - 9, 243 + 14, 199 + 10)


def test_smallest_window_is_seven_pixels() -> None:
    """So that a background is seen about the blob."""
    blob = candidate_at(243, 199, sigma_x=0.6, sigma_y=0.6)
    assert sigma_window(EVEN, blob, 128, sigmas=3.0) == (240, 196, 247, 203)


def test_the_border_cuts_the_window() -> None:
    """It has no pixels beyond the frame."""
    assert sigma_window(EVEN, candidate_at(2, 398), 128, sigmas=3.0) == (0, 392, 9, 400)


def test_a_blob_wider_than_allowed_is_none() -> None:
    """The greatest half-width holds."""
    blob = candidate_at(243, 199, sigma_x=12.0, sigma_y=12.0)
    assert sigma_window(EVEN, blob, 35, sigmas=3.0) is None
    assert sigma_window(EVEN, blob, 36, sigmas=3.0) is not None


@pytest.mark.parametrize('sigma', [0.6, 1.0, 2.0, 4.0, 8.0, 16.0, 33.0, 40.0])
def test_window_follows_the_blob(sigma: float) -> None:
    """From 0.6 to 40 px: three sigma, and a pixel of rounding."""
    contrast = noisy_blob((400, 480), 243.3, 198.6, sigma, 150.0)
    box = sigma_window(contrast, searched(contrast).candidates[0], 128, sigmas=3.0)
    assert box is not None
    half = max(3.0 * np.hypot(sigma, 0.29), 3.0)  # the pixel's own width adds to the light's
    # The background of the widest is taken where they still have 0.6 % of their height.
    rel = 0.15 if sigma > 30.0 else 0.1
    for first, last, middle in ((box.x0, box.x1, 243.3), (box.y0, box.y1, 198.6)):
        assert (last - first - 1) / 2 == pytest.approx(half, rel=rel, abs=1.0)
        assert (last + first - 1) / 2 == pytest.approx(middle, abs=0.51 + 0.1 * sigma)

"""The window follows the blob's width and place from sigma 0.6 to 40 px."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.sigma_window import measure_extent, sigma_window
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SHAPE = (400, 480)
X, Y = 243.3, 198.6
NOISE = SensorNoise(gain=np.inf, read_noise=1.0)
DEVIATION = float(np.sqrt(2 * (1.0 + 1 / 12)))  # of a difference pixel


def pair(amplitude: float, sigma_x: float, sigma_y: float, seed: int = 1) -> Contrast:
    """Return a blob of this peak at (X, Y) on 40 DN, with read noise of 1 DN."""
    random = np.random.default_rng(seed)
    mean = np.full(SHAPE, 40.0)
    blob = pixel_integrated_gaussian(SHAPE, X, Y, sigma_x, sigma_y)
    lit, unlit = (
        expose(level, NOISE, random) for level in (mean + amplitude * blob, mean)
    )
    return Contrast(lit, unlit, 0.0, DEVIATION)


def brightest(contrast: Contrast) -> tuple[int, int]:
    """Return column and row of the strongest rise."""
    rise = contrast.signal(Box(0, 0, SHAPE[1], SHAPE[0]))
    row, column = np.unravel_index(int(rise.argmax()), rise.shape)
    return int(column), int(row)


@pytest.mark.parametrize('sigma', [0.6, 1.0, 2.0, 4.0, 7.9, 8.1, 16.0, 31.0, 33.0, 40.0])
def test_sigma_and_place_are_measured(sigma: float) -> None:
    """Within 3 % and a tenth of sigma, from the brightest pixel, at a peak SNR of 100."""
    contrast = pair(150.0, sigma, sigma)
    extent = measure_extent(contrast, *brightest(contrast), largest=43.0)
    assert extent is not None
    # The pixel adds its own width, 1/12 px^2, to the light's; binning adds 3 % at the largest.
    expected = np.hypot(sigma, 0.29)
    assert extent.sigma_x == pytest.approx(expected, rel=0.03, abs=0.1)
    assert extent.sigma_y == pytest.approx(expected, rel=0.03, abs=0.1)
    assert np.hypot(extent.x - X, extent.y - Y) < 0.1 * expected


@pytest.mark.parametrize('sigma', [1.5, 3.0, 10.0, 40.0])
def test_a_faint_blob_is_not_taken_for_its_brightest_noise(sigma: float) -> None:
    """At a peak SNR of 7 the brightest pixel may be far from the middle of a wide blob."""
    for seed in range(5):
        contrast = pair(7 * DEVIATION, sigma, sigma, seed)
        extent = measure_extent(contrast, *brightest(contrast), largest=43.0)
        assert extent is not None
        assert extent.sigma_x == pytest.approx(sigma, rel=0.25)
        assert np.hypot(extent.x - X, extent.y - Y) < 0.3 * sigma


def test_snr_is_that_of_the_matched_filter() -> None:
    """SNR = amplitude sqrt(sum of the squared pulse) / noise, the root sqrt(pi) sigma."""
    extent = measure_extent(pair(50.0, 4.0, 4.0), 243, 199, largest=43.0)
    assert extent is not None
    # Its own noise is 1; the weight's width is off by a per cent or so.
    assert extent.snr == pytest.approx(np.sqrt(np.pi) * 4.0 * 50.0 / DEVIATION, rel=0.03)


def test_each_axis_has_its_own_width() -> None:
    """A blob twice as wide as high gives such a box."""
    extent = measure_extent(pair(150.0, 6.0, 3.0), 243, 199, largest=43.0)
    assert extent is not None
    assert extent.sigma_x == pytest.approx(6.0, rel=0.05)
    assert extent.sigma_y == pytest.approx(3.0, rel=0.05)


def test_window_is_so_many_sigma_to_either_side() -> None:
    """Three sigma of 4 px, re-centred from a start two pixels off."""
    box = sigma_window(pair(150.0, 4.0, 4.0), 241, 200, 128, sigmas=3.0)
    # 12 px, rounded up with what the pixel and the noise add.
    assert box == Box(243 - 13, 199 - 13, 243 + 14, 199 + 14)


def test_smallest_window_is_seven_pixels() -> None:
    """So that a background is seen about the blob."""
    assert sigma_window(pair(150.0, 0.6, 0.6), 243, 199, 128, sigmas=3.0) == (240, 196, 247, 203)


def test_a_blob_wider_than_allowed_is_none() -> None:
    """The greatest half-width holds."""
    contrast = pair(150.0, 12.0, 12.0)
    assert sigma_window(contrast, 243, 199, 30, sigmas=3.0) is None
    assert sigma_window(contrast, 243, 199, 40, sigmas=3.0) is not None


def test_an_uneven_background_is_left_out() -> None:
    """A single frame has a level of its own, here 40 DN in all and 30 DN more about the blob."""
    contrast = pair(100.0, 3.0, 3.0)
    lit = contrast.lit + np.uint8(30) * (pixel_integrated_gaussian(SHAPE, X, Y, 60) > 0.5)
    extent = measure_extent(Contrast(lit.astype(np.uint8), None, 40.0, 1.04), 243, 199, 43.0)
    assert extent is not None
    assert extent.sigma_x == pytest.approx(3.0, rel=0.05)


def test_nothing_gives_nothing() -> None:
    """Equal frames have no blob anywhere."""
    flat = np.full(SHAPE, 40, dtype=np.uint8)
    assert measure_extent(Contrast(flat, flat, 0.0, 0.4), 100, 100, 43.0) is None
    assert measure_extent(Contrast(flat[:2], flat[:2], 0.0, 0.4), 100, 1, 43.0) is None

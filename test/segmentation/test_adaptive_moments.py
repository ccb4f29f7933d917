"""Place, widths and SNR of blobs from sigma 0.6 to 40 px."""

from __future__ import annotations

from blob_tracker.segmentation.adaptive_moments import measure, scratch
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.simulation import expose, pixel_integrated_gaussian
import numpy as np
import pytest
from support.contrasts import contrast_of, DEVIATION, noisy_blob, READ_NOISE

SHAPE = (400, 480)
X, Y = 243.3, 198.6
FIELDS = Candidate._fields[:9]


def measured(
    contrast: Contrast,
    column: int = 243,
    row: int = 199,
    *,
    level: float = 0.0,
    least: float = 7.0,
    largest: float = 64.0,
    region: tuple[int, int, int, int] | None = None,
) -> dict[str, float]:
    """Return what is measured at a peak, by name."""
    height, width = contrast.shape
    found = measure(
        contrast.lit, contrast.unlit, region or (0, 0, width, height), column, row, level,
        DEVIATION, least, largest, scratch(),
    )
    return dict(zip(FIELDS, found, strict=True))


def brightest(contrast: Contrast) -> tuple[int, int]:
    """Return column and row of the strongest rise."""
    rise = contrast.lit.astype(int) - contrast.unlit
    row, column = np.unravel_index(int(rise.argmax()), rise.shape)
    return int(column), int(row)


@pytest.mark.parametrize('sigma', [0.6, 1.0, 1.9, 2.1, 4.0, 7.9, 8.1, 16.0, 31.0, 33.0, 40.0])
def test_sigma_place_and_snr_are_measured(sigma: float) -> None:
    """From the brightest pixel, at a peak SNR of 100."""
    contrast = noisy_blob(SHAPE, X, Y, sigma, 150.0)
    found = measured(contrast, *brightest(contrast))
    # The pixel adds its own width, 1/12 px^2, to the light's.
    expected = np.hypot(sigma, 0.29)
    assert found['sigma_x'] == pytest.approx(expected, rel=0.03, abs=0.1)
    assert found['sigma_y'] == pytest.approx(expected, rel=0.03, abs=0.1)
    assert np.hypot(found['x'] - X, found['y'] - Y) < 0.1 * expected
    # The light of the whole blob, 2 pi sigma^2 A, in the filter that has the blob's own width.
    peak = 150.0 * (sigma / expected) ** 2
    snr = peak * np.sqrt(np.pi) * expected / DEVIATION
    # Below 1 px the sum over the pixels is not the integral.
    assert found['snr'] == pytest.approx(snr, rel=0.15 if sigma < 1.0 else 0.05)


@pytest.mark.parametrize('sigma', [1.5, 3.0, 10.0, 40.0])
def test_a_faint_blob_is_not_taken_for_its_brightest_noise(sigma: float) -> None:
    """At a peak SNR of 7 the brightest pixel may be far from the middle of a wide blob."""
    for seed in range(5):
        contrast = noisy_blob(SHAPE, X, Y, sigma, 7 * DEVIATION, seed=seed)
        found = measured(contrast, *brightest(contrast))
        assert found['sigma_x'] == pytest.approx(sigma, rel=0.25)
        assert np.hypot(found['x'] - X, found['y'] - Y) < 0.3 * sigma


def test_each_axis_has_its_own_width() -> None:
    """A blob twice as wide as high: the width of the binned pixels is taken off again."""
    found = measured(noisy_blob(SHAPE, X, Y, 6.0, 150.0, sigma_y=3.0))
    for name, true in (('x', 6.0), ('y', 3.0), ('major', 6.0), ('minor', 3.0)):
        assert found[f'sigma_{name}'] == pytest.approx(true, rel=0.03)


def test_a_slanted_blob_has_its_axes_and_their_correlation() -> None:
    """Sigma of 5 and 2.5 px at 45 degrees: variances of 15.6, correlation (a - b) / (a + b)."""
    y, x = np.mgrid[:SHAPE[0], :SHAPE[1]]
    along, across = (x - X + y - Y) / np.sqrt(2), (y - Y - x + X) / np.sqrt(2)
    light = 150.0 * np.exp(-0.5 * ((along / 5.0) ** 2 + (across / 2.5) ** 2))
    random = np.random.default_rng(1)
    lit, unlit = (
        expose(mean, READ_NOISE, random) for mean in (40.0 + light, np.full(SHAPE, 40.0))
    )
    found = measured(contrast_of(lit, unlit))
    assert found['sigma_major'] == pytest.approx(5.0, rel=0.05)
    assert found['sigma_minor'] == pytest.approx(2.5, rel=0.05)
    assert found['sigma_x'] == pytest.approx(np.sqrt(15.6), rel=0.05)
    assert found['correlation'] == pytest.approx(0.6, abs=0.05)


@pytest.mark.parametrize('shade, level', [(5, 0.0), (30, 25.0), (30, 32.0)])
def test_a_light_background_is_left_out(shade: int, level: float) -> None:
    """A disc of 70 px about the blob, whose level is known to 5 DN: the ring tells it."""
    contrast = noisy_blob(SHAPE, X, Y, 3.0, 100.0)
    disc = np.uint8(shade) * (pixel_integrated_gaussian(SHAPE, X, Y, 60.0) > 0.5)
    found = measured(contrast._replace(lit=contrast.lit + disc), level=level)
    assert found['sigma_x'] == pytest.approx(3.0, rel=0.05)
    # The median of about 90 pixels, each with a noise of 1.5 DN.
    assert found['background'] == pytest.approx(shade, abs=0.7)


def test_noise_alone_holds_no_blob() -> None:
    """At the highest of 192,000 pixels, 4.5 standard deviations, in ten frames."""
    for seed in range(10):
        contrast = noisy_blob(SHAPE, X, Y, 1.0, 0.0, seed=seed)
        assert measured(contrast, *brightest(contrast))['snr'] < 7.0


def test_equal_frames_hold_no_blob() -> None:
    """Anywhere: in the middle, in the corner, and in what is too small."""
    flat = np.full(SHAPE, 40, np.uint8)
    assert measured(contrast_of(flat, flat), 100, 100)['snr'] == 0.0
    assert measured(contrast_of(flat, flat), 0, 0)['snr'] == 0.0
    assert measured(contrast_of(flat[:2], flat[:2]), 100, 1)['snr'] == 0.0


def test_what_is_wider_than_the_largest_is_none() -> None:
    """The limit is on sigma."""
    contrast = noisy_blob(SHAPE, X, Y, 12.0, 150.0)
    assert measured(contrast, largest=10.0)['snr'] == 0.0
    assert measured(contrast, largest=14.0)['snr'] > 100.0


def test_pixels_beyond_the_region_are_not_looked_at() -> None:
    """A light outside of it changes nothing."""
    contrast = noisy_blob(SHAPE, X, Y, 3.0, 100.0)
    region = (213, 169, 274, 229)
    lit = np.full_like(contrast.lit, 255)
    lit[169:229, 213:274] = contrast.lit[169:229, 213:274]
    alone = measured(contrast, region=region)
    assert measured(contrast._replace(lit=lit), region=region) == alone
    assert alone['sigma_x'] == pytest.approx(3.0, rel=0.05)

"""A light whose flash lights up haze or a wall about it: the light is the blob, not its glow."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import Candidates, table_of
from blob_tracker.segmentation.rejection import mark_glows
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of, searched

SHAPE = (240, 320)
NOISE = SensorNoise(gain=10.0, read_noise=1.0)
X, Y = 160.3, 120.4  # px


def scene(peak: float, sigma: float, glow: float, width: float, aside: float) -> np.ndarray:
    """Return the mean of a frame with a light, and a glow aside of it, DN."""
    return 30.0 + (
        peak * pixel_integrated_gaussian(SHAPE, X, Y, sigma)
        + glow * pixel_integrated_gaussian(SHAPE, X + aside, Y, width)
    )


@pytest.mark.parametrize('peak, sigma, glow, width, aside', [
    (100.0, 1.5, 10.0, 20.0, 20.0),
    (100.0, 1.5, 20.0, 20.0, 20.0),
    (100.0, 1.5, 40.0, 20.0, 20.0),
    (150.0, 1.5, 40.0, 20.0, 20.0),
    (100.0, 1.5, 40.0, 20.0, 0.0),
    (100.0, 1.5, 40.0, 20.0, 40.0),
    (100.0, 1.0, 60.0, 10.0, 8.0),
    (100.0, 3.0, 40.0, 25.0, 20.0),
    (100.0, 0.8, 40.0, 40.0, 20.0),
    (100.0, 1.5, 60.0, 12.0, 12.0),
])
def test_the_light_is_the_blob(
    peak: float, sigma: float, glow: float, width: float, aside: float
) -> None:
    """Its window is about it and no wider than a third more than without the glow."""
    random = np.random.default_rng(7)
    segmenter = Segmenter()
    lit, unlit = scene(peak, sigma, glow, width, aside), np.full(SHAPE, 30.0)
    found = 0
    for index in range(40):
        image = expose(lit if index % 2 == 0 else unlit, NOISE, random)
        window = segmenter.update(Frame(image, 1 + index * 10**7, 255))
        if index < 10:
            continue
        assert (window is None) or index % 2 == 0
        if window is not None:
            height, wide = window.lit.shape
            assert abs(window.x0 + (wide - 1) / 2 - X) <= 1.5
            assert abs(window.y0 + (height - 1) / 2 - Y) <= 1.5
            assert max(height, wide) <= 2 * np.ceil(4.0 * sigma) + 3
            found += 1
    assert found >= 14


@pytest.mark.parametrize('sigma', [4.0, 10.0, 16.0])
@pytest.mark.parametrize('peak, gain', [(40.0, np.inf), (150.0, 10.0), (200.0, 0.5)])
def test_a_wide_light_is_no_glow(sigma: float, peak: float, gain: float) -> None:
    """Its own shot noise, a hundred times that of the tile, is no light on it."""
    random = np.random.default_rng(8)
    noise = SensorNoise(gain=gain, read_noise=1.0)
    lit = 5.0 + peak * pixel_integrated_gaussian(SHAPE, X, Y, sigma)
    for _ in range(5):
        found = searched(contrast_of(
            expose(lit, noise, random), expose(np.full(SHAPE, 5.0), noise, random)
        ))
        best, = (each for each in found.candidates if not each.rejected)
        assert best.sigma_x == pytest.approx(sigma, rel=0.1)
        assert abs(best.x - X) < 0.1 * sigma and abs(best.y - Y) < 0.1 * sigma


def marked(lights: list[Candidate]) -> Candidates:
    """Return the candidates with the glows among them rejected."""
    table = table_of(lights)
    mark_glows(table)
    return Candidates(table)


def test_only_what_is_far_wider_about_a_light_is_a_glow() -> None:
    """And only where the narrow one may be a target itself."""
    wide = candidate_at(100, 100, sigma_x=20.0, sigma_y=20.0, sigma_major=20.0, sigma_minor=20.0)
    narrow = candidate_at(120, 100)
    glow, light = marked([wide, narrow])
    assert glow.rejected.startswith('a glow 20 px wide (sigma) about the light at (120, 100)')
    assert light == narrow
    hot = narrow._replace(rejected='a lone pixel')
    far = candidate_at(170, 100)
    broad = narrow._replace(sigma_major=8.0)
    for other in (hot, far, broad):
        assert ['glow' in each.rejected for each in marked([wide, other])] == [False, False]

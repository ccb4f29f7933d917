"""Windows of which some pixels do not see the light."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location import locate, METHODS
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
SITES = np.tile(np.array([[True, False], [False, False]]), (9, 9))


def window(seed: int = 1) -> Window:
    """Return a light that red sites alone see; the others are clipped by what they see."""
    random = np.random.default_rng(seed)
    along_y, along_x = (integrated_profile(18, centre, 1.5)[0] for centre in (8.2, 9.4))
    lit = random.poisson(300.0 + 1200.0 * np.outer(along_y, along_x)) / 10.0
    unlit = random.poisson(300.0, (18, 18)) / 10.0
    lit[~SITES] = unlit[~SITES] = 255.0
    return Window(lit, unlit, saturation=255, sites=SITES)


def test_what_other_pixels_hold_does_not_matter() -> None:
    """Bit by bit, and none of them counts as saturated."""
    first = locate(window(), noise=NOISE)
    other = window()
    other.lit[~SITES], other.unlit[~SITES] = 3.0, 77.0
    second = locate(other, noise=NOISE)
    assert (first.x, first.y, first.chi2, first.saturated) == (
        second.x, second.y, second.chi2, second.saturated)
    assert first.saturated == 0
    assert first.x == pytest.approx(9.4, abs=0.15) and first.y == pytest.approx(8.2, abs=0.15)


@pytest.mark.parametrize('paired', [True, False])
@pytest.mark.parametrize('saturation', [255, None])
def test_a_quarter_of_the_pixels_tells_twice_the_sigma(
    paired: bool, saturation: int | None
) -> None:
    """They have a quarter of the light."""
    part = replace(window(), saturation=saturation)
    whole = replace(part, lit=np.where(SITES, part.lit, np.nan), sites=None)
    along_y, along_x = (integrated_profile(18, centre, 1.5)[0] for centre in (8.2, 9.4))
    whole = replace(whole, lit=30.0 + 120.0 * np.outer(along_y, along_x),
                    unlit=np.full((18, 18), 30.0))
    if not paired:
        part, whole = replace(part, unlit=None), replace(whole, unlit=None)
    ratio = locate(part, noise=NOISE).covariance / locate(whole, noise=NOISE).covariance
    assert 3.0 < ratio[0, 0] < 6.0 and 3.0 < ratio[1, 1] < 6.0


def test_a_clipped_site_is_left_out() -> None:
    """As in any window."""
    clipped = window()
    clipped.lit[8, 10] = 255.0
    found = locate(clipped, noise=NOISE)
    assert found.saturated == 1
    assert found.x == pytest.approx(9.4, abs=0.4)


@pytest.mark.parametrize('method', [each for each in METHODS if each != 'maximum_likelihood'])
def test_methods_that_need_every_pixel_say_so(method: str) -> None:
    """With what to do."""
    with pytest.raises(LocationError, match='needs every pixel .* take maximum_likelihood'):
        locate(window(), method=method, noise=NOISE)


def test_added_noise_is_in_the_covariance() -> None:
    """As so much more read noise would be, in each of the looks."""
    plain = replace(window(), looks=2)
    noisy = locate(replace(plain, added_noise=2.0), noise=NOISE)
    same = locate(plain, noise=replace(NOISE, read_noise=float(np.hypot(1.0, 2.0))))
    np.testing.assert_array_equal(noisy.covariance, same.covariance)


def test_a_ghost_on_a_mosaic_is_fitted_by_its_samples() -> None:
    """Take the pixels of other colours for no dark ones: the ghost would be 0.1 px off."""
    random = np.random.default_rng(6)
    squares = []
    for _ in range(24):
        x, y = 8.5 + random.uniform(-1.0, 1.0, 2)
        images = []
        for peak, shift in ((1200.0, 0.0), (240.0, -0.8)):
            along_y = integrated_profile(18, y, 2.0)[0]
            along_x = integrated_profile(18, x + shift, 2.0)[0]
            images.append(np.rint(
                random.poisson(300.0 + peak * SITES * np.outer(along_y, along_x)) / 10.0
                + random.normal(size=(18, 18))
            ))
        lit, unlit = images
        found = locate(Window(lit, unlit, saturation=255, sites=SITES), noise=NOISE)
        off = np.array([found.x - x, found.y - y])
        squares.append(off @ np.linalg.solve(found.covariance, off))
    # The mean of 24 is 2 +- 0.4; 9.6 where all pixels of the unlit window are samples.
    assert np.mean(squares) < 3.4

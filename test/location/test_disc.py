"""Size and flux of a light: right within the covariance, from points to wide discs."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location import locate
from blob_tracker.location.disc import fit_disc
from blob_tracker.types import LocationError
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.stats import chi2
from support.discs import disc_window, NOISE

RUNS = 120


@pytest.mark.parametrize('radius, psf, flux, side, unlit', [
    (0.0, 1.2, 3000.0, 15, True), (1.0, 1.2, 3000.0, 15, True), (2.0, 1.2, 5000.0, 19, False),
    (5.0, 1.0, 12000.0, 25, True),
])
def test_errors_are_those_of_the_covariance(
    radius: float, psf: float, flux: float, side: int, unlit: bool
) -> None:
    """Of the squared radius and the flux together, and neither is biased."""
    random = np.random.default_rng(int(10 * radius))
    squared, scaled = 0.0, []
    for _ in range(RUNS):
        window = disc_window(radius, psf, flux, side, random, unlit=unlit)
        disc = fit_disc(window, locate(window, noise=NOISE), noise=NOISE, psf_sigma=psf)
        error = np.array([disc.square - radius**2, disc.flux - flux])
        squared += float(error @ np.linalg.solve(disc.covariance, error))
        scaled.append(error / np.sqrt(disc.covariance.diagonal()))
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], 2 * RUNS)
    assert 0.97 * low < squared < 1.03 * high
    assert (np.abs(np.mean(scaled, axis=0)) < 4.5 / np.sqrt(RUNS)).all()


def test_a_disc_of_many_widths() -> None:
    """Of 20 px, in a window of which each second pixel is fitted: within five sigma."""
    window = disc_window(20.0, 1.0, 2e5, 75, np.random.default_rng(2))
    disc = fit_disc(window, locate(window, noise=NOISE), noise=NOISE, psf_sigma=1.0)
    sigma = np.sqrt(disc.covariance.diagonal())
    assert (np.abs([disc.square - 400.0, disc.flux - 2e5]) < 5.0 * sigma).all()
    assert disc.chi2 == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize('texture, told', [(0.0, 39), (4.0, 0)])
def test_a_texture_that_nothing_takes_off_is_refused(texture: float, told: int) -> None:
    """Its pixels are alike, as those of noise are not: by chance in one window of 700."""
    random = np.random.default_rng(5)
    count = 0
    for _ in range(40):
        window = disc_window(1.0, 1.2, 5000.0, 19, random, unlit=False)
        wall = gaussian_filter(random.normal(size=(19, 19)), 2.0)
        lit = np.rint(window.lit + texture * wall / wall.std()).clip(0).astype(np.uint16)
        window = replace(window, lit=lit)
        try:
            fit_disc(window, locate(window, noise=NOISE), noise=NOISE, psf_sigma=1.2)
        except LocationError as error:
            assert 'a texture about the light' in str(error)
        else:
            count += 1
    assert count >= told and (count == 0) == (told == 0)


def test_what_is_no_disc_is_doubted_or_refused() -> None:
    """Two lights grow the covariance; a window without pixels has no size."""
    random = np.random.default_rng(3)
    window = disc_window(0.0, 1.2, 3000.0, 19, random)
    location = locate(window, noise=NOISE)
    once = fit_disc(window, location, noise=NOISE, psf_sigma=1.2)
    brighter = np.array(window.lit)
    brighter[:, 13] += 60
    window = replace(window, lit=brighter)
    twice = fit_disc(window, location, noise=NOISE, psf_sigma=1.2)
    assert once.chi2 < 1.3 < 5.0 < twice.chi2
    assert twice.covariance[1, 1] > 3.0 * once.covariance[1, 1]
    with pytest.raises(LocationError, match='too few pixels'):
        small = replace(disc_window(0.0, 1.2, 3000.0, 19, random), saturation=1)
        fit_disc(small, location, noise=NOISE, psf_sigma=1.2)

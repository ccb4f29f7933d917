"""Shapes of light: a peak of 1, the centre of gravity at the truth, no light lost."""

from __future__ import annotations

from blob_tracker.location import multi_gaussian
from blob_tracker.simulation import (
    Comatic, Gaussian, Measured, pixel_integrated_gaussian, PROFILES, ThreeGaussians,
)
from blob_tracker.simulation.profiles import LAMP_AMPLITUDES, LAMP_WIDTHS, Profile
import numpy as np
import pytest
from scipy.integrate import dblquad

SIDE, SIGMA = 121, 2.3
X, Y = 60.3, 59.6
FINE = Measured(pixel_integrated_gaussian((129, 129), 64.0, 64.0, 8.0), elements=8.0)
ALL = {
    **PROFILES,
    'elliptical': Gaussian(axis_ratio=2.0),
    'elliptical, turned': Gaussian(axis_ratio=2.0, angle=0.6),
    'comatic, turned': Comatic(1.4, angle=-2.0),
    'measured': FINE,
}


def moments(picture: np.ndarray) -> tuple[float, float, float, float, float]:
    """Return centre of gravity and variances of x and y, and their covariance, px and px^2."""
    rows, columns = np.indices(picture.shape)
    light = picture / picture.sum()
    x, y = (light * columns).sum(), (light * rows).sum()
    return (
        x, y, (light * (columns - x) ** 2).sum(), (light * (rows - y) ** 2).sum(),
        (light * (columns - x) * (rows - y)).sum(),
    )


def test_the_lamp_is_the_one_from_which_the_fits_start() -> None:
    """The thesis' numbers stand in two places, as the lab does without the locators' compiler."""
    assert LAMP_AMPLITUDES == multi_gaussian.LAMP_AMPLITUDES
    assert LAMP_WIDTHS == multi_gaussian.LAMP_WIDTHS


@pytest.mark.parametrize('name', ALL)
def test_the_centre_of_gravity_is_the_truth(name: str) -> None:
    """To what is cut off at the border of 26 sigma: the thesis' lamp reaches farthest."""
    x, y, *_ = moments(ALL[name].over_pixels((SIDE, SIDE), X, Y, SIGMA))
    assert (x, y) == pytest.approx((X, Y), abs=2e-4)


@pytest.mark.parametrize('name', ALL)
def test_the_peak_is_1_and_where_it_is_said_to_be(name: str) -> None:
    """Seen by points, 8 of them to a sigma; the measured spot is known to an element, 1/8."""
    profile: Profile = ALL[name]
    picture = profile.over_pixels((SIDE, SIDE), 60.0, 60.0, 8.0, aperture=0.0)
    row, column = np.unravel_index(picture.argmax(), picture.shape)
    assert picture.max() == pytest.approx(1.0, abs=0.006)
    assert ((column - 60) / 8.0, (row - 60) / 8.0) == pytest.approx(profile.peak, abs=0.13)


def test_gaussian_of_any_direction_is_the_integral_over_the_pixel() -> None:
    """Against quadrature in two dimensions, on the flank and at the peak."""
    angle, along, across = 0.6, SIGMA * 2.0**0.5, SIGMA / 2.0**0.5
    picture = Gaussian(2.0, angle).over_pixels((12, 12), 5.3, 6.2, SIGMA)
    for row, column in ((6, 5), (8, 7), (3, 2)):
        def density(v: float, u: float) -> float:
            far = np.cos(angle) * (u - 5.3) + np.sin(angle) * (v - 6.2)
            near = np.cos(angle) * (v - 6.2) - np.sin(angle) * (u - 5.3)
            return float(np.exp(-0.5 * (far / along) ** 2 - 0.5 * (near / across) ** 2))

        expected, _ = dblquad(density, column - 0.5, column + 0.5, row - 0.5, row + 0.5)
        assert picture[row, column] == pytest.approx(expected, rel=1e-7)


def test_the_long_axis_lies_where_it_is_said_to() -> None:
    """From x towards y; each variance is the Gaussian's and that of the pixel, 1/12."""
    angle = 0.6
    picture = Gaussian(2.0, angle).over_pixels((SIDE, SIDE), X, Y, SIGMA)
    _, _, xx, yy, xy = moments(picture)
    along, across = 2.0 * SIGMA**2, 0.5 * SIGMA**2
    assert xx == pytest.approx(along * np.cos(angle)**2 + across * np.sin(angle)**2 + 1 / 12)
    assert yy == pytest.approx(along * np.sin(angle)**2 + across * np.cos(angle)**2 + 1 / 12)
    assert xy == pytest.approx((along - across) * np.sin(angle) * np.cos(angle))


def test_the_thesis_lamp_has_the_peaks_and_widths_that_it_prints() -> None:
    """Eq. 4.35 at the pixels' centres, s without a 2 in the exponent: 254 DN in all."""
    s = 1.5
    found = 254.0 * ThreeGaussians().over_pixels((15, 15), 7.2, 6.9, s / 2**0.5, aperture=0.0)
    rows, columns = np.indices((15, 15))
    square = (columns - 7.2) ** 2 + (rows - 6.9) ** 2
    expected = sum(
        peak * np.exp(-square / (width * s) ** 2)
        for peak, width in ((154.25, 1.0), (77.68, 2.57), (22.07, 4.97))
    )
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_coma_draws_a_tail_and_moves_the_peak_off_the_centre_of_gravity() -> None:
    """The third moment along the tail is positive, and the peak lies on the other side."""
    profile = Comatic(1.4)
    along = profile.over_pixels((SIDE, SIDE), X, Y, SIGMA).sum(axis=0)
    places = np.arange(SIDE) - X
    assert (along * places**3).sum() / along.sum() > SIGMA**3
    x, y = profile.peak
    assert x < -0.5 and y == 0.0
    assert Comatic(0.0).over_pixels((9, 9), 4.2, 4.1, 1.3) == pytest.approx(
        Gaussian().over_pixels((9, 9), 4.2, 4.1, 1.3)
    )


def test_a_measured_gaussian_is_a_gaussian() -> None:
    """8 elements to a sigma: the elements' own width does not come in, the spline's error does."""
    found = FINE.over_pixels((25, 25), 12.3, 11.6, 2.0)
    expected = Gaussian().over_pixels((25, 25), 12.3, 11.6, 2.0)
    assert found / found.max() == pytest.approx(expected / expected.max(), abs=1e-4)


@pytest.mark.parametrize('sigma', [0.4, 3.0, 7.0])
def test_a_measured_spot_loses_no_light_at_any_scale(sigma: float) -> None:
    """Even where its sigma is less than a pixel."""
    total = FINE.over_pixels((151, 151), 75.2, 74.9, sigma).sum()
    assert total / sigma**2 == pytest.approx(
        FINE.picture.sum() / FINE.picture.max() / FINE.elements**2, rel=1e-9
    )


def test_a_picture_that_is_no_spot_is_named() -> None:
    """With what would be right."""
    with pytest.raises(ValueError, match='brighter than its background'):
        Measured(np.zeros((9, 9)), 4.0)
    with pytest.raises(ValueError, match='4 x 4 elements or more'):
        Measured(np.ones(9), 4.0)


@pytest.mark.parametrize('fill_factor', [1.0, 0.5, 0.0])
def test_fill_factor_is_the_part_of_the_pixel_that_sees(fill_factor: float) -> None:
    """The mean over the square in its middle; the picture's variance has a^2 / 12 of it."""
    aperture = fill_factor**0.5
    picture = pixel_integrated_gaussian((41, 41), 20.3, 19.8, SIGMA, aperture=aperture)
    _, _, xx, yy, _ = moments(picture)
    assert (xx, yy) == pytest.approx((SIGMA**2 + fill_factor / 12,) * 2, rel=1e-9)
    # The peak of the light is 1; sampling does not change the sum of a pulse as wide as this.
    assert picture.sum() == pytest.approx(2 * np.pi * SIGMA**2, rel=1e-9)

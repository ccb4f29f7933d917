"""Ranges by size and flux: right within their variance, or refused with a reason."""

from __future__ import annotations

from math import hypot

from blob_tracker.camera import CameraModel
from blob_tracker.camera.light_range import (
    angle_per_pixel, combined, LightRange, range_by_flux, range_by_size, RangeError, Ranging,
)
from blob_tracker.types import Location
import numpy as np
import pytest
from scipy.stats import chi2

RUNS = 2000


def within(squared: float) -> bool:
    """Tell whether a sum of RUNS squares is in the middle 99.98 % of its distribution."""
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], RUNS)
    return bool(low < squared < high)


def test_errors_are_those_of_the_variance() -> None:
    """Of what was measured and of what was calibrated, each drawn anew."""
    random = np.random.default_rng(1)
    true, pixel, diameter, width, known = 8.0, 1.1e-3, 0.08, 1.3, 0.01
    radius = diameter / (2.0 * true) / pixel
    of_size = of_flux = 0.0
    for _ in range(RUNS):
        square = radius**2 * (1.0 + 0.04 * random.normal())
        square -= 8.0 * width**2 * known * random.normal()
        found = range_by_size(
            square, (0.04 * radius**2) ** 2, pixel=pixel,
            diameter=diameter * (1.0 + known * random.normal()), psf_sigma=width,
            calibration_sigma=known,
        )
        of_size += (found.distance - true) ** 2 / found.variance
        flux = 4e3 * (5.0 / true) ** 2 * (1.0 + 0.03 * random.normal())
        found = range_by_flux(
            flux, (0.03 * flux) ** 2,
            reference_distance=5.0 * (1.0 + known * random.normal()), reference_flux=4e3,
            calibration_sigma=known,
        )
        of_flux += (found.distance - true) ** 2 / found.variance
    # The radius is not quite Gaussian any more where its square is known to 6 %.
    assert within(0.97 * of_size)
    assert within(of_flux)


def test_a_pixel_is_seen_under_the_angle_of_the_lens() -> None:
    """In the middle 1 / f; at an angle t off it cos(t)^(3/2) of that, of a pinhole."""
    model = CameraModel.from_field_of_view(640, 480, 60.0)
    focal = model.matrix[0, 0]
    for x, y in ((319.5, 239.5), (600.0, 239.5), (30.0, 450.0)):
        location = Location(x, y, np.diag([0.01, 0.03]), 1.0, 0.0, 1.0, 1.0, 1.0, 0)
        away = hypot(x - 319.5, y - 239.5) / focal
        expected = (1.0 + away**2) ** -0.75 / focal
        assert angle_per_pixel(location, model.bearing(location)) == pytest.approx(
            expected, rel=1e-6)


def test_what_tells_nothing_is_refused() -> None:
    """A point, a faint light, and two that contradict each other."""
    known = {'pixel': 1e-3, 'diameter': 0.1, 'psf_sigma': 1.2, 'calibration_sigma': 0.01}
    with pytest.raises(RangeError, match='not resolved: its squared radius is 0.05'):
        range_by_size(0.05, 0.04**2, **known)
    assert range_by_size(4.0, 0.04**2, **known).distance == pytest.approx(25.0, rel=1e-5)
    with pytest.raises(RangeError, match='too faint'):
        range_by_flux(
            40.0, 100.0, reference_distance=1.0, reference_flux=1e3, calibration_sigma=0.0)
    one, other = LightRange(10.0, 0.01, 0.01), LightRange(10.2, 0.04)
    both = combined(one, other)
    assert both.distance == pytest.approx(10.04)
    assert both.variance == pytest.approx(0.008)
    assert both.angle == 0.01
    with pytest.raises(RangeError, match='10 m and 13 m, 13.4 sigma apart'):
        combined(one, LightRange(13.0, 0.04))


def test_size_and_flux_of_one_fit_go_together() -> None:
    """Drawn with their covariance: the error is that of the variance, and the least there is."""
    random = np.random.default_rng(2)
    true, square, flux = 5.0, 4.0, 4e3
    relative = np.array([[0.02**2, 0.7 * 0.02 * 0.01], [0.7 * 0.02 * 0.01, 0.01**2]])
    squared = taken_apart = 0.0
    for off_square, off_flux in random.multivariate_normal(np.zeros(2), relative, RUNS):
        one = range_by_size(
            square * (1.0 + off_square), relative[0, 0] * square**2, pixel=1e-3,
            diameter=2.0 * true * np.tan(1e-3 * square**0.5), psf_sigma=1.2,
            calibration_sigma=0.0,
        )
        other = range_by_flux(
            flux * (1.0 + off_flux), relative[1, 1] * flux**2, reference_distance=true,
            reference_flux=flux, calibration_sigma=0.0,
        )
        found = combined(one, other, relative[0, 1] / 4.0)
        squared += (found.distance - true) ** 2 / found.variance
        found = combined(one, other)
        taken_apart += (found.distance - true) ** 2 / found.variance
    assert within(squared)
    assert taken_apart > 1.15 * squared


@pytest.mark.parametrize('words, sentence', [
    ({'psf_sigma': 0.0, 'diameter': 0.1}, 'range.psf_sigma is 0'),
    ({'psf_sigma': 1.0, 'reference_flux': 10.0}, 'go together'),
])
def test_what_is_missing_is_named(words: dict[str, float], sentence: str) -> None:
    """By the names of the parameters."""
    with pytest.raises(ValueError, match=sentence):
        Ranging(**words)

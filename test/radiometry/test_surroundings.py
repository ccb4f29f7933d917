"""What the air takes."""

from __future__ import annotations

from blob_tracker.radiometry import Surroundings
import pytest


def test_at_the_visual_range_two_per_cent_are_left() -> None:
    """Of green light, whatever the range: that is what Koschmieder's visual range is."""
    for visibility in (1.0, 10.0, 23.0, 60.0):
        left = Surroundings(visibility).transmittance(1e3 * visibility, 550.0)
        assert left == pytest.approx(0.02, rel=1e-3)


@pytest.mark.parametrize(
    'visibility, wavelength, left',
    [
        (23.0, 850.0, 0.90793),  # exp(-3.912 / 23 (850 / 550)^-1.3), by hand
        (1.0, 850.0, 0.04819),   # q = 0.585: exp(-3.912 x 1.54545^-0.585)
        (60.0, 850.0, 0.96803),  # q = 1.6: exp(-0.0652 x 1.54545^-1.6)
    ],
)
def test_infrared_goes_further(visibility: float, wavelength: float, left: float) -> None:
    """One kilometre, by Kruse's exponents."""
    around = Surroundings(visibility)
    assert around.transmittance(1000.0, wavelength) == pytest.approx(left, abs=1e-5)
    assert around.transmittance(1000.0, wavelength) > around.transmittance(1000.0, 550.0)


def test_night_is_dark() -> None:
    """By eight orders of magnitude less one; the sky has its own colour."""
    day, night = Surroundings().radiance(), Surroundings(light='night').radiance()
    assert (night == pytest.approx(1e-7 * day))
    assert (Surroundings(sky=True).radiance() < day).all()

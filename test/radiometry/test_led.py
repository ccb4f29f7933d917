"""Power and beam to intensity; what a pass band lets through."""

from __future__ import annotations

from math import pi, radians, sin

from blob_tracker.radiometry import Led
import pytest


def test_a_matt_surface_sends_its_power_over_pi() -> None:
    """60 degrees is the cosine: 3 W of which 0.35 is light make 0.334 W/sr, half of it at 60."""
    assert Led(3.0).intensity() == pytest.approx(3.0 * 0.35 / pi)
    assert Led(3.0, off_axis=60.0).intensity() == pytest.approx(0.5 * 3.0 * 0.35 / pi)


@pytest.mark.parametrize('half_angle', [5.0, 20.0, 60.0, 80.0])
def test_a_lobe_holds_all_of_the_power(half_angle: float) -> None:
    """Summed over the hemisphere, and it is half as bright at the half-angle."""
    steps = 2000
    angles = [90.0 * (step + 0.5) / steps for step in range(steps)]
    power = sum(
        Led(1.0, half_angle=half_angle, off_axis=angle).intensity()
        * 2.0 * pi * sin(radians(angle)) * radians(90.0 / steps) for angle in angles
    )
    assert power == pytest.approx(0.35, rel=1e-3)  # the sum's own steps
    on_axis = Led(1.0, half_angle=half_angle).intensity()
    aside = Led(1.0, half_angle=half_angle, off_axis=half_angle).intensity()
    assert aside == pytest.approx(0.5 * on_axis)


def test_a_pass_band_as_wide_as_the_line() -> None:
    """A Gaussian has 0.761 of itself within its full width at half maximum."""
    assert Led(1.0).passed(20.0) == pytest.approx(0.7610, abs=1e-4)
    assert Led(1.0).passed(float('inf')) == 1.0

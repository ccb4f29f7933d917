"""Light before a lens to electrons, by hand."""

from __future__ import annotations

from blob_tracker.radiometry import Led, Receiver, Surroundings
from blob_tracker.radiometry.receiver import matched_snr
import numpy as np
import pytest


def test_a_flash_by_hand() -> None:
    """
    1 W of light from a matt surface at 1 km, 630 nm, 10 mm of aperture, 1 ms.

    1 / pi W/sr make 3.183e-7 W/m^2 and, on 7.854e-5 m^2 for 1 ms, 2.5e-14 J; at 3.153e-19 J a
    photon 79,290 of them, of which lens (0.8) and pixel (0.5 x 0.87, between 600 and 650 nm) take
    27,593.
    """
    light = Led(1.0, efficiency=1.0)
    camera = Receiver(focal_length=25.0, f_number=2.5, transmission=0.8, quantum_efficiency=0.5)
    electrons = camera.electrons_of(light, light.intensity() / 1000.0**2)
    assert electrons == pytest.approx(27_593.0, rel=1e-3)
    short = Led(1.0, efficiency=1.0, flash=0.25e-3)
    assert camera.electrons_of(short, 1.0) == pytest.approx(camera.electrons_of(light, 1.0) / 4.0)


def test_a_sunlit_scene_by_hand() -> None:
    """
    Albedo 0.3 through 10 nm at 550 nm, f/2.5, 3.45 um, 1 ms.

    0.1473 W/m^2/sr/nm x pi / 25 x 10 nm make 0.1851 W/m^2, on 1.190e-11 m^2 for 1 ms 2.203e-15 J;
    at 3.612e-19 J a photon 6099 of them, of which lens and filter (0.8 x 0.9) and pixel (0.5 x
    0.99) take 2174.
    """
    camera = Receiver(
        f_number=2.5, transmission=0.8, quantum_efficiency=0.5, filter_width=10.0,
    )
    assert camera.background(Surroundings().radiance(), 550.0) == pytest.approx(2174.0, rel=2e-3)
    wide = Receiver(f_number=2.5, transmission=0.8, quantum_efficiency=0.5)
    assert wide.background(Surroundings().radiance(), 550.0) > 30.0 * 2174.0


def test_a_filter_between_two_steps() -> None:
    """5 nm about 555 nm are half of the mean of the two steps."""
    def through(middle: float, width: float) -> float:
        return Receiver(filter_width=width).background(Surroundings().radiance(), middle)

    both = through(550.0, 10.0) + through(560.0, 10.0)
    assert through(555.0, 5.0) == pytest.approx(0.25 * both)


def test_a_blob_by_hand() -> None:
    """Blur 0.8, diffraction 0.42 x 0.63 x 2.8 / 3.45, a ball of 10 cm at 100 m 1.81 px."""
    expected = np.sqrt(0.8**2 + 0.2147**2 + 1.8116**2)
    assert Receiver().sigma(Led(1.0, diameter=0.1), 100.0) == pytest.approx(expected, rel=1e-4)


def test_the_matched_filter_is_that_of_the_pixels() -> None:
    """Summed over pixels: w = exp(-r^2 / 2 sigma^2) on a blob of its own width."""
    y, x = np.mgrid[-20:21, -20:21]
    weight = np.exp(-(x**2 + y**2) / (2.0 * 1.7**2))
    summed = (weight * 40.0 * weight).sum() / np.sqrt(25.0 * (weight**2).sum())
    assert matched_snr(40.0, 1.7, 25.0) == pytest.approx(summed, rel=1e-6)

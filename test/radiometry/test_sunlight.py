"""The standard's sunlight, and what of it scene and sky send back."""

from __future__ import annotations

from blob_tracker.radiometry.sunlight import (
    DIRECT, GLOBAL, scene_radiance, sky_radiance, STEP, WAVELENGTHS,
)
import numpy as np


def test_full_sun_is_as_bright_as_is_said() -> None:
    """110,000 lx: 683 lm/W by the eye's sensitivity, a Gaussian about 559 nm that fits it."""
    eye = 1.019 * np.exp(-285.4 * (1e-3 * WAVELENGTHS - 0.559) ** 2)
    assert abs(683.0 * STEP * eye @ GLOBAL - 110_000.0) < 5_000.0


def test_irradiance_of_the_visible_and_near_infrared() -> None:
    """700 of the 1000 W/m^2 of the standard lie between 395 and 1005 nm, and the direct less."""
    assert abs(STEP * GLOBAL.sum() - 700.0) < 10.0
    assert (DIRECT < GLOBAL).all()


def test_a_matt_scene() -> None:
    """By hand at 550 nm, albedo 0.3: 0.3 x 1.542 / pi; and a tenth of it under clouds."""
    green = int(np.argmin(abs(WAVELENGTHS - 550.0)))
    assert abs(scene_radiance(0.3)[green] - 0.1473) < 1e-4
    assert np.allclose(scene_radiance(0.3, 0.1), 0.1 * scene_radiance(0.3))


def test_the_sky_is_blue() -> None:
    """Darker than a scene of albedo 0.3, and more so in the red."""
    share = sky_radiance() / scene_radiance(0.3)
    assert (share < 1.0).all() and share[5] > 1.5 * share[25]

"""The benchmarks' own Cramer-Rao bound against the package's: two derivations, one figure."""

from __future__ import annotations

from typing import Any

from benchmarks.bound import bound
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
import pytest

NOISE = SensorNoise(gain=3.0, read_noise=1.2)
SHAPE = (9, 11)
X, Y, SIGMA, AMPLITUDE, BACKGROUND = 5.3, 3.8, 1.4, 150.0, 12.0
# Central differences with steps of 1e-4 and a background of 1e-1 of the peak: 7 digits stay.
CLOSE: dict[str, Any] = {'rtol': 1e-5, 'atol': 1e-11}


def given(sigma_y: float = SIGMA) -> NDArray[np.float64]:
    """Return the parameters in the order of the benchmarks."""
    return np.array([X, Y, SIGMA, sigma_y, AMPLITUDE, BACKGROUND])


def expected(**options: Any) -> NDArray[np.float64]:
    """Return the package's bound of the same pulse."""
    return cramer_rao_bound(
        SHAPE, x=X, y=Y, sigma=SIGMA, amplitude=AMPLITUDE, background=BACKGROUND, noise=NOISE,
        **options,
    )


def test_background_in_the_fit() -> None:
    """Agree for a lit window alone."""
    np.testing.assert_allclose(bound(SHAPE, given(), NOISE), expected(), **CLOSE)


def test_unlit_window() -> None:
    """Agree for lit less unlit, with the noise of both."""
    unlit = np.full(SHAPE, BACKGROUND)
    np.testing.assert_allclose(
        bound(SHAPE, given(), NOISE, unlit=unlit), expected(unlit=True), **CLOSE
    )


@pytest.mark.parametrize('sigma_y', [SIGMA, 1.9])
def test_two_widths(sigma_y: float) -> None:
    """Agree for the elliptical fit, on a round pulse too."""
    np.testing.assert_allclose(
        bound(SHAPE, given(sigma_y), NOISE, elliptical=True), expected(sigma_y=sigma_y), **CLOSE
    )


def test_clipped_pixels() -> None:
    """Agree where the pixels whose mean reaches full scale are left out."""
    mean = AMPLITUDE * pixel_integrated_gaussian(SHAPE, X, Y, SIGMA, SIGMA) + BACKGROUND
    assert 3 < (mean >= 60.0).sum() < 30
    np.testing.assert_allclose(
        bound(SHAPE, given(), NOISE, used=mean < 60.0), expected(saturation=60.0), **CLOSE
    )

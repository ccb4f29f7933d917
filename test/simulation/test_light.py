"""The pixel-integrated Gaussian against numerical integration."""

from blob_tracker.simulation import pixel_integrated_gaussian
import numpy as np
import pytest
from scipy.integrate import dblquad


@pytest.mark.parametrize('sigma_x, sigma_y', [(0.6, 0.6), (2.0, 1.2)])
def test_pixels_are_integrals(sigma_x: float, sigma_y: float) -> None:
    """A few pixels agree with the integral over their area to the quadrature's error."""
    x, y = 3.3, 2.8
    pulse = pixel_integrated_gaussian((6, 7), x, y, sigma_x, sigma_y)
    for row, column in ((3, 3), (2, 4), (0, 1)):
        integral, _ = dblquad(
            lambda v, u: np.exp(
                -((u - x) ** 2) / (2 * sigma_x**2) - (v - y) ** 2 / (2 * sigma_y**2)
            ),
            column - 0.5,
            column + 0.5,
            row - 0.5,
            row + 0.5,
        )
        assert pulse[row, column] == pytest.approx(integral, rel=1e-7)


def test_total_is_that_of_the_gaussian() -> None:
    """A wide window holds 2 pi sigma^2 times the peak."""
    pulse = pixel_integrated_gaussian((41, 41), 20.2, 19.7, 2.0)
    assert pulse.sum() == pytest.approx(2 * np.pi * 4.0, rel=1e-12)

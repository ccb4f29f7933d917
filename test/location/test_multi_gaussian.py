"""Three Gaussians with one mean, by simplex and by Levenberg-Marquardt."""

from blob_tracker.location import locate
from blob_tracker.location.multi_gaussian import (
    jacobian,
    jacobian_1d,
    three_gaussians,
    three_gaussians_1d,
)
from blob_tracker.location.multi_gaussian_lm import multi_gaussian_lm_1d
from blob_tracker.location.multi_gaussian_simplex import multi_gaussian_simplex_1d
from blob_tracker.location.pulse import sampled_profile
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(gain=np.inf, read_noise=0.0)
AMPLITUDES = np.array([154.25, 77.68, 22.07])
WIDTHS = np.array([1.0, 2.57, 4.97]) / np.sqrt(2.0)


def thesis_pulse(size, x, y, s):
    """Return the test pulse of section 4.3.2."""
    return three_gaussians(np.concatenate([[x, y], AMPLITUDES, s * WIDTHS]), size, size)


def test_model_is_the_sum_of_sampled_profiles():
    """Agree with the profiles of the pulse module, elliptical."""
    theta = np.concatenate([[4.2, 3.9], AMPLITUDES, 2.0 * WIDTHS, 1.5 * WIDTHS])
    down = sampled_profile(8, np.full(3, 3.9), 1.5 * WIDTHS)[0]
    across = sampled_profile(9, np.full(3, 4.2), 2.0 * WIDTHS)[0]
    np.testing.assert_allclose(
        three_gaussians(theta, 8, 9), (AMPLITUDES[:, None] * down).T @ across, rtol=1e-12
    )


@pytest.mark.parametrize('parameters', [8, 11])
def test_jacobian_is_the_models_slope(parameters):
    """Agree with central differences."""
    theta = np.concatenate([[4.2, 3.9], AMPLITUDES, 2.0 * WIDTHS, 1.5 * WIDTHS])[:parameters]
    for p in range(parameters):
        step = np.zeros(parameters)
        step[p] = 1e-5
        slope = (three_gaussians(theta + step, 8, 9) - three_gaussians(theta - step, 8, 9)) / 2e-5
        np.testing.assert_allclose(jacobian(theta, 8, 9)[:, p], slope.ravel(), atol=1e-6)


def test_jacobian_1d_is_the_models_slope():
    """Agree with central differences."""
    theta = np.concatenate([[4.2], AMPLITUDES, 2.0 * WIDTHS])
    for p in range(7):
        step = np.zeros(7)
        step[p] = 1e-5
        slope = (three_gaussians_1d(theta + step, 9) - three_gaussians_1d(theta - step, 9)) / 2e-5
        np.testing.assert_allclose(jacobian_1d(theta, 9)[:, p], slope, atol=1e-6)


# The simplex stops on the squares' scatter, the algorithm with slopes near machine precision.
@pytest.mark.parametrize(
    ('fit', 'tolerance'), [(multi_gaussian_lm_1d, 1e-4), (multi_gaussian_simplex_1d, 0.01)]
)
def test_1d(fit, tolerance):
    """Place the unrounded row of the thesis."""
    for displacement in (-0.3, 0.1, 0.4):
        theta = np.concatenate([[7.0 + displacement], AMPLITUDES, 2.0 * WIDTHS])
        assert fit(three_gaussians_1d(theta, 15))[0] == pytest.approx(theta[0], abs=tolerance)
    for row in (np.ones(6), np.zeros(9), np.full(9, np.nan)):
        with pytest.raises(LocationError, match='at least 7'):
            fit(row)


def test_1d_refuses_a_mean_outside_the_row():
    """Say so where the least squares of seven rounded, nearly flat pixels lie far away."""
    theta = np.concatenate([[3.18], AMPLITUDES, 10.0 * WIDTHS])
    with pytest.raises(LocationError, match='leaves the row'):
        multi_gaussian_lm_1d(np.rint(three_gaussians_1d(theta, 7)))


@pytest.mark.parametrize(
    ('method', 'tolerance'), [('multi_gaussian_lm', 1e-4), ('multi_gaussian_simplex', 0.005)]
)
@pytest.mark.parametrize('elliptical', [False, True])
def test_unrounded_pulse(method, tolerance, elliptical):
    """Place the thesis' pulse where it is (Table 4.8)."""
    lit = thesis_pulse(15, 7.23, 6.66, 2.0)
    found = locate(
        Window(lit, np.zeros_like(lit)), method=method, noise=NOISE, elliptical=elliptical
    )
    assert found.x == pytest.approx(7.23, abs=tolerance)
    assert found.y == pytest.approx(6.66, abs=tolerance)


@pytest.mark.parametrize(
    ('size', 's', 'printed'), [(5, 1, 0.0034), (15, 1, 0.0027), (15, 7, 0.0042)]
)
def test_rounded_pulse_errs_no_more_than_the_thesis(size, s, printed):
    """Stay below the largest errors of Table 4.9, on a sparser grid of displacements."""
    errors = []
    for dx in np.arange(-0.5, 0.5, 0.14):
        for dy in np.arange(-0.5, 0.5, 0.2):
            middle = (size - 1) / 2
            lit = np.rint(thesis_pulse(size, middle + dx, middle + dy, float(s)))
            found = locate(
                Window(lit, np.zeros_like(lit)), method='multi_gaussian_lm', noise=NOISE
            )
            errors.append(abs(found.x - middle - dx))
    # The largest of a grid depends on its steps, which the thesis does not give for this table.
    assert max(errors) <= 1.2 * printed


def test_clipped_pixels_are_left_out():
    """Place a clipped pulse by its flanks."""
    lit = np.minimum(thesis_pulse(15, 7.23, 6.66, 2.0), 150.0)
    found = locate(
        Window(lit, np.zeros_like(lit), saturation=150), method='multi_gaussian_lm', noise=NOISE
    )
    assert found.x == pytest.approx(7.23, abs=1e-3)
    assert found.saturated > 0


def test_too_few_pixels():
    """Refuse where fewer pixels than parameters are left."""
    lit = np.rint(thesis_pulse(3, 1.0, 1.0, 2.0))
    with pytest.raises(LocationError, match='too few pixels'):
        locate(
            Window(lit, np.zeros_like(lit)), method='multi_gaussian_lm', noise=NOISE,
            elliptical=True,
        )

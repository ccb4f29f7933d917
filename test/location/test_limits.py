"""The Cramer-Rao bound against closed forms and brute force; Havelock's locales by moving."""

from typing import Any

from blob_tracker.location.limits import cramer_rao_bound, cramer_rao_bound_1d, locale_extent
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

NOISE = SensorNoise(gain=2.0, read_noise=1.5)
PULSE: dict[str, Any] = {'x': 5.2, 'y': 4.9, 'sigma': 1.4, 'amplitude': 120.0, 'background': 15.0}


def brute_force(mean, theta, variance):
    """Invert the Fisher information of a mean function, differentiated numerically."""
    theta = np.asarray(theta, dtype=float)
    columns = []
    for p in range(theta.size):
        step = 1e-5 * max(abs(theta[p]), 1.0)
        high, low = theta.copy(), theta.copy()
        high[p] += step
        low[p] -= step
        columns.append((mean(high) - mean(low)).ravel() / (2.0 * step))
    slopes = np.array(columns)
    return np.linalg.inv(slopes @ (slopes / variance.ravel()).T)[:2, :2]


def test_constant_noise_well_sampled_blob_has_the_textbook_bound():
    """Hold sqrt(2 / pi) / SNR px where the noise is constant, whatever sigma is."""
    noise = SensorNoise(gain=np.inf, read_noise=2.0)
    bound = cramer_rao_bound(
        (25, 25), x=12.3, y=11.8, sigma=2.0, amplitude=100.0, background=10.0, noise=noise
    )
    snr = 100.0 / np.sqrt(2.0**2 + 1.0 / 12.0)
    # Integration over the pixels adds 1/12 to sigma^2 = 4: 2 % of the variance.
    assert np.sqrt(bound[0, 0]) == pytest.approx(np.sqrt(2.0 / np.pi) / snr, rel=0.03)


@pytest.mark.parametrize('unlit', [False, True])
def test_circular_bound_is_the_inverse_of_the_fisher_information(unlit):
    """Agree with numerical derivatives, background fitted or known."""
    def mean(theta):
        x, y, peak, sigma = theta[:4]
        down, across = integrated_profile(11, y, sigma)[0], integrated_profile(11, x, sigma)[0]
        return peak * down[:, None] * across + (15.0 if unlit else theta[4])

    theta = [5.2, 4.9, 120.0, 1.4] + ([] if unlit else [15.0])
    floor = NOISE.read_noise**2 + 1.0 / 12.0
    variance = mean(np.array(theta)) / NOISE.gain + floor
    if unlit:
        variance = variance + 15.0 / NOISE.gain + floor
    bound = cramer_rao_bound((11, 11), noise=NOISE, unlit=unlit, **PULSE)
    np.testing.assert_allclose(bound, brute_force(mean, theta, variance), rtol=1e-6, atol=1e-12)


def test_elliptical_and_sampled_bound():
    """Agree with numerical derivatives for the sampled elliptical pulse."""
    def mean(theta):
        x, y, peak, across, down, level = theta
        return peak * np.outer(
            sampled_profile(11, y, down)[0], sampled_profile(11, x, across)[0]
        ) + level

    theta = np.array([5.2, 4.9, 120.0, 1.4, 2.1, 15.0])
    variance = mean(theta) / NOISE.gain + NOISE.read_noise**2 + 1.0 / 12.0
    bound = cramer_rao_bound((11, 11), noise=NOISE, sigma_y=2.1, sampled=True, **PULSE)
    np.testing.assert_allclose(bound, brute_force(mean, theta, variance), rtol=1e-5, atol=1e-12)


def test_three_gaussians_bound():
    """Agree with numerical derivatives for the thesis' pulse of three Gaussians."""
    peaks, widths = np.array([154.25, 77.68, 22.07]), np.array([1.0, 2.57, 4.97])

    def mean(theta):
        down = sampled_profile(25, np.full(3, theta[1]), theta[5:8])[0]
        across = sampled_profile(25, np.full(3, theta[0]), theta[5:8])[0]
        return (theta[2:5, None] * down).T @ across + theta[8]

    theta = np.concatenate([[12.2, 11.9], peaks, widths, [15.0]])
    variance = mean(theta) / NOISE.gain + NOISE.read_noise**2 + 1.0 / 12.0
    bound = cramer_rao_bound(
        (25, 25), x=12.2, y=11.9, sigma=widths, amplitude=peaks, background=15.0, noise=NOISE,
        sampled=True,
    )
    # The nine parameters nearly stand in for one another: numerical slopes lose half the digits.
    np.testing.assert_allclose(bound, brute_force(mean, theta, variance), rtol=1e-3, atol=1e-9)


def test_row_bound():
    """Agree with numerical derivatives; a row of two pixels has too few for three parameters."""
    def mean(theta):
        return theta[1] * sampled_profile(9, theta[0], theta[2])[0]

    theta = [4.3, 200.0, 1.6]
    bound = cramer_rao_bound_1d(
        9, x=4.3, sigma=1.6, amplitude=200.0, variance=1.2, sampled=True
    )
    expected = brute_force(mean, theta, np.full(9, 1.2))[0, 0]
    assert bound == pytest.approx(expected, rel=1e-6)
    with pytest.raises(ValueError, match='do not determine'):
        cramer_rao_bound_1d(2, x=0.4, sigma=1.6, amplitude=200.0, variance=1.2)


def test_clipped_pixels_carry_nothing():
    """Grow with the clipped area, and refuse where nothing is left."""
    free = cramer_rao_bound((11, 11), noise=NOISE, **PULSE)
    clipped = cramer_rao_bound((11, 11), noise=NOISE, saturation=60.0, **PULSE)
    assert (np.linalg.eigvalsh(clipped - free) > 0.0).all()
    with pytest.raises(ValueError, match='do not determine'):
        cramer_rao_bound((11, 11), noise=NOISE, saturation=10.0, **PULSE)


def test_known_background_never_harms():
    """Lie below the bound with two windows' noise and the background fitted."""
    known = cramer_rao_bound((7, 7), noise=NOISE, unlit=True, **{**PULSE, 'x': 3.3, 'y': 2.8})
    single = cramer_rao_bound((7, 7), noise=NOISE, **{**PULSE, 'x': 3.3, 'y': 2.8})
    doubled = 2.0 * single
    assert (np.linalg.eigvalsh(doubled - known) > 0.0).all()


def test_locale_is_as_wide_as_the_pulse_can_move():
    """Keep every rounded pixel inside a locale, and change one just outside it."""
    def picture(x, y):
        down, across = sampled_profile(9, y, 1.2)[0], sampled_profile(9, x, 1.2)[0]
        return np.rint(20.0 * np.outer(down, across) + 5.0)

    xs, ys = np.linspace(3.6, 4.4, 9), np.array([3.9, 4.25])
    extent = locale_extent((9, 9), x=xs, y=ys, sigma=1.2, amplitude=20.0, background=5.0)
    assert extent.shape == (2, 9)
    for row, y in enumerate(ys):
        for column, x in enumerate(xs):
            # Walk to either side until a pixel changes, in steps of 1e-5 px.
            walked = 0.0
            for direction in (-1e-5, 1e-5):
                steps = 0
                while (picture(x + direction * (steps + 1), y) == picture(x, y)).all():
                    steps += 1
                walked += steps * 1e-5
            assert extent[row, column] == pytest.approx(walked, abs=2.1e-5)

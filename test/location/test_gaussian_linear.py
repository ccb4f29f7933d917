"""The log-linear fits: exact without noise, tame with weights, and honest about too little."""

from blob_tracker.location import locate, locate_batch
from blob_tracker.location.gaussian_linear import gaussian_linear_1d
from blob_tracker.location.pulse import sampled_profile
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(gain=4.0, read_noise=1.0)


def sampled_pulse(size, x, y, sigma, sigma_y=None, amplitude=250.0):
    """Return the thesis' pulse, which is sampled at the pixels' centres."""
    down = sampled_profile(size, y, sigma if sigma_y is None else sigma_y)[0]
    return amplitude * np.outer(down, sampled_profile(size, x, sigma)[0])


@pytest.mark.parametrize('weighted', [False, True])
def test_1d_is_exact_without_noise(weighted):
    """Return centre, sigma and amplitude of an unrounded row."""
    found = gaussian_linear_1d(200.0 * sampled_profile(11, 4.7, 1.6)[0], weighted=weighted)
    np.testing.assert_allclose(found, (4.7, 1.6, 200.0), rtol=1e-9)


def test_1d_refuses_too_little():
    """Need three pixels with light that falls from a peak."""
    for row in ([0, 5, 9, 0, 0], [9, 5, 2, 5, 9], []):
        with pytest.raises(LocationError):
            gaussian_linear_1d(row)


@pytest.mark.parametrize('weighted', [False, True])
def test_exact_without_noise(weighted):
    """Place unrounded pulses to 1e-9 px: Table 4.3's errors are single precision's."""
    lit = np.stack([sampled_pulse(9, 4.3, 3.8, 1.5), sampled_pulse(9, 3.6, 4.45, 3.0)])
    for method in ('gaussian_linear', 'gaussian_linear_elliptical'):
        found = locate_batch(
            lit, np.zeros_like(lit), method=method, noise=NOISE, weighted=weighted
        )
        np.testing.assert_allclose(found.x, [4.3, 3.6], atol=1e-9)
        np.testing.assert_allclose(found.y, [3.8, 4.45], atol=1e-9)
        np.testing.assert_allclose(found.sigma, [1.5, 3.0], atol=1e-9)
        np.testing.assert_allclose(found.amplitude, 250.0, rtol=1e-9)


def test_elliptical_is_exact_on_an_ellipse():
    """Take the axes' widths apart."""
    lit = sampled_pulse(13, 6.3, 5.8, 1.5, 2.5)
    found = locate(
        Window(lit, np.zeros_like(lit)), method='gaussian_linear_elliptical', noise=NOISE
    )
    assert found.x == pytest.approx(6.3, abs=1e-9)
    assert found.y == pytest.approx(5.8, abs=1e-9)
    assert found.sigma == pytest.approx(np.sqrt(1.5 * 2.5), abs=1e-9)


def test_weights_tame_the_noise(scene):
    """Bring the rms down by a factor of three at least."""
    shots = scene(9, 1.3, 200.0, count=2000, noise=NOISE, unlit=True)
    plain = shots.errors(shots.locate('gaussian_linear'))
    weighted = shots.errors(shots.locate('gaussian_linear', weighted=True))
    assert weighted.std() < plain.std() / 3.0


def test_too_few_points_are_a_failure():
    """Need four pixels that are not on one line."""
    lit = np.zeros((9, 9))
    lit[4, 2:7] = [20.0, 60.0, 90.0, 60.0, 20.0]
    with pytest.raises(LocationError, match='too few pixels'):
        locate(Window(lit, np.zeros_like(lit)), method='gaussian_linear', noise=NOISE)


def test_light_that_does_not_fall_is_a_failure():
    """Refuse a bowl: its vertex is no peak."""
    rows, columns = np.mgrid[0:7, 0:7] - 3.0
    lit = 20.0 * np.exp((rows**2 + columns**2) / 20.0)
    with pytest.raises(LocationError, match='wider than the window'):
        locate(Window(lit, np.zeros_like(lit)), method='gaussian_linear', noise=NOISE)


def test_clipped_pixels_are_left_out():
    """Place a clipped pulse by its flanks."""
    lit = np.minimum(sampled_pulse(11, 5.3, 4.8, 1.6, amplitude=800.0), 255.0)
    found = locate(
        Window(lit, np.zeros_like(lit), saturation=255), method='gaussian_linear', noise=NOISE
    )
    assert found.x == pytest.approx(5.3, abs=1e-9)
    assert found.amplitude == pytest.approx(800.0, rel=1e-9)
    assert found.saturated > 0

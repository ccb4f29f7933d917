"""The look-up: at the bound, at the right place for any pulse, within Havelock's locales."""

from blob_tracker.location import locate, locate_batch
from blob_tracker.location.limits import cramer_rao_bound, locale_extent
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.location.ratio_tables import tables_up_to
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest

EVEN = SensorNoise(gain=1e9, read_noise=1.0)
SHOT = SensorNoise(gain=8.0, read_noise=0.3)


def pulses(size, x, y, sigma, sigma_y=None, profile=integrated_profile):
    """Return (N, size, size) unit pulses at x, y from the window's middle."""
    middle = (size - 1) / 2
    down = profile(size, middle + y, sigma if sigma_y is None else sigma_y)[0]
    return down[:, :, None] * profile(size, middle + x, sigma)[0][:, None, :]


@pytest.mark.parametrize('noise', [EVEN, SHOT])
@pytest.mark.parametrize('unlit', [False, True])
@pytest.mark.parametrize(('size', 'sigma', 'amplitude'), [
    (5, 0.9, 100.0), (7, 1.3, 100.0), (9, 0.8, 50.0), (9, 1.5, 20.0), (9, 1.5, 400.0),
    (15, 1.0, 30.0), (15, 2.5, 100.0), (15, 5.0, 100.0), (31, 8.0, 30.0),
])
def test_error_over_the_bound(scene, noise, unlit, size, sigma, amplitude):
    """At most 1.06 times it: 1.04 and twice the sampling error of 4000 positions, 0.8 %."""
    shots = scene(size, sigma, amplitude, count=2000, noise=noise, unlit=unlit)
    found = shots.locate('locale_table')
    assert found.ok.mean() > 0.995
    rms = np.sqrt((shots.errors(found) ** 2).mean())
    bounds = [
        np.trace(cramer_rao_bound(
            (size, size), x=x, y=y, sigma=sigma, amplitude=amplitude, background=20.0,
            noise=noise, unlit=unlit,
        )) / 2
        for x, y in zip(shots.x[:40], shots.y[:40])
    ]
    assert rms < 1.06 * np.sqrt(np.mean(bounds))


@pytest.mark.parametrize('size', [9, 10, 24])
@pytest.mark.parametrize(('sigma', 'sigma_y'), [(0.7, 0.7), (1.5, 1.5), (1.2, 1.8), (2.8, 2.8)])
def test_without_noise_it_is_the_place(size, sigma, sigma_y):
    """Within 5e-4 px, what bilinear look-up leaves of a table of 33 nodes: anywhere but cut."""
    random = np.random.default_rng(4)
    reach = size / 2 - 2.5 * max(sigma, 0.6)
    x, y = random.uniform(-max(reach, 0.5), max(reach, 0.5), (2, 300))
    pixels = 900.0 * pulses(size, x, y, sigma, sigma_y) + 30.0
    found = locate_batch(pixels, method='locale_table', noise=EVEN)
    assert found.ok.all()
    middle = (size - 1) / 2
    assert np.abs(found.x - middle - x).max() < 5e-4 * max(sigma, 1.0)
    assert np.abs(found.y - middle - y).max() < 5e-4 * max(sigma_y, 1.0)
    np.testing.assert_allclose(found.amplitude, 900.0, rtol=5e-3)
    np.testing.assert_allclose(found.background, 30.0, atol=1.0)
    np.testing.assert_allclose(found.sigma, np.sqrt(sigma * sigma_y), rtol=5e-3)


def test_amplitude_and_background_do_not_move_it():
    """The ratios are the same to rounding: no table of its own for each amplitude."""
    pulse = pulses(9, np.array([0.21]), np.array([-0.33]), 1.3)
    places = [
        locate_batch(amplitude * pulse + level, method='locale_table', noise=EVEN)
        for amplitude, level in ((40.0, 0.0), (900.0, 0.0), (900.0, 5000.0))
    ]
    for found in places[1:]:
        assert found.x[0] == pytest.approx(places[0].x[0], abs=1e-9)
        assert found.y[0] == pytest.approx(places[0].y[0], abs=1e-9)


def test_rounded_pulses_are_placed_near_their_locale():
    """
    Of the thesis' pulse, rounded and without noise: at the bound of rounding noise.

    All of a locale's places give one picture, so not knowing which leaves the exact map an error
    of extent / sqrt(12). That is half of what 1/12 DN^2 of noise in each pixel allow
    a locator that is told neither the amplitude nor the width, at these 9 x 9 pixels.
    """
    sigma, amplitude = 1.5 / np.sqrt(2.0), 255.0
    grid = np.arange(-0.5, 0.5, 0.05)
    y, x = (axis.ravel() for axis in np.meshgrid(grid, grid, indexing='ij'))
    rounded = np.rint(amplitude * pulses(9, x, y, sigma, profile=sampled_profile))
    found = locate_batch(rounded, method='locale_table', noise=SensorNoise(1e9, 0.0))
    assert found.ok.all()
    error = np.hypot(found.x - 4.0 - x, found.y - 4.0 - y)
    extent = locale_extent((9, 9), x=4.0 + grid, y=4.0 + grid, sigma=sigma, amplitude=amplitude)
    bound = np.sqrt(cramer_rao_bound(
        (9, 9), x=4.2, y=4.1, sigma=sigma, amplitude=amplitude, background=0.0,
        noise=SensorNoise(1e9, 0.0), sampled=True,
    )[0, 0])
    rms = np.sqrt((error**2).mean() / 2)
    # The tables are those of integrated pulses, and a rounded pixel is not noise: 10 % each.
    assert rms < 1.2 * bound
    assert np.sqrt((extent**2).mean() / 12.0) < 0.7 * rms


def test_clipped_pixels_are_refused():
    """Say so where one lies in the blob, and place it where one lies far from it."""
    pixels = np.rint(240.0 * pulses(15, np.array([0.1]), np.array([0.2]), 1.2)[0])
    free = locate(Window(pixels, saturation=255), method='locale_table', noise=EVEN)
    pixels[0, 14] = 255.0
    corner = locate(Window(pixels, saturation=255), method='locale_table', noise=EVEN)
    assert corner.saturated == 1
    assert corner.x == pytest.approx(free.x, abs=1e-9)
    with pytest.raises(LocationError, match='no look-up can leave out'):
        locate(Window(pixels, saturation=200), method='locale_table', noise=EVEN)
    unlit = np.zeros_like(pixels)
    unlit[6, 9] = 100.0
    with pytest.raises(LocationError, match='no look-up can leave out'):
        locate(Window(pixels / 3.0, unlit, saturation=100), method='locale_table', noise=EVEN)


@pytest.mark.parametrize(('sigma', 'x', 'amplitude', 'reason'), [
    (0.15, 0.0, 100.0, 'single pixel'), (6.0, 0.0, 1000.0, 'wider than the window'),
    (1.3, 4.1, 100.0, 'outside|no light|not settle'), (1.3, 0.0, 1.0, 'no light'),
])
def test_what_the_tables_do_not_hold_is_refused(sigma, x, amplitude, reason):
    """With a reason: too narrow, too wide, on the window's edge, too faint."""
    pixels = amplitude * pulses(9, np.array([x]), np.array([0.1]), sigma)[0] + 10.0
    with pytest.raises(LocationError, match=reason):
        locate(Window(pixels), method='locale_table', noise=EVEN)


def test_a_pulse_anywhere_in_the_window_is_right_or_refused(scene):
    """No error beyond six standard deviations where the pulse lies half a pixel inside."""
    random = np.random.default_rng(6)
    x, y = random.uniform(-4.0, 4.0, (2, 4000))
    lit = 200.0 * pulses(9, x, y, 1.3) + 20.0
    lit = np.rint(lit + random.standard_normal(lit.shape) * np.sqrt(lit / 8.0 + 0.3**2))
    found = locate_batch(lit, method='locale_table', noise=SHOT)
    inside = np.maximum(np.abs(x), np.abs(y)) < 3.3
    assert found.ok[inside].mean() > 0.98
    errors = np.stack([found.x - 4.0 - x, found.y - 4.0 - y], axis=1)[found.ok & inside]
    covariance = found.covariance[found.ok & inside]
    assert np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariance), errors).max() < 36.0


def test_tables_are_made_once():
    """And those of short supports are the same in the tables of larger windows."""
    small, large = tables_up_to(16), tables_up_to(32)
    assert tables_up_to(16) is small
    np.testing.assert_array_equal(large.value[:len(small.length)], small.value)
    assert np.isfinite(large.value).all()
    # Every length has a table that is no longer than it, of its own parity.
    for length in range(3, 33):
        own = large.length[large.of_length[length]]
        assert own <= length
        assert (length - own) % 2 == 0

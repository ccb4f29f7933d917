"""The skew error in closed form, as the thesis derives it, and the centroid without it."""

from blob_tracker.location.centroid import centroid_1d
from blob_tracker.location.pulse import sampled_profile
from blob_tracker.location.skew import skew_error
from blob_tracker.types import SensorNoise
import numpy as np
import pytest


def bell(offset, s):
    """Return the thesis' Gaussian."""
    return np.exp(-((offset / s) ** 2))


@pytest.mark.parametrize('s', [1.0, 2.0, 4.5])
@pytest.mark.parametrize('n', [3, 4])
def test_equation_3_27(n, s):
    """Agree with eq. 3.27: a window of 2n pixels, from -n + 1 to n, and delta above zero."""
    for delta in (0.1, 0.3, 0.49):
        i = np.arange(1, n + 1)
        above = (i - delta) * bell(i - delta, s) - (i + delta - 1) * bell(i + delta - 1, s)
        below = bell(np.arange(-n + 1, n + 1) - delta, s)
        found = skew_error(2 * n, n - 1 + delta, s / np.sqrt(2.0), sampled=True)
        assert found == pytest.approx(above.sum() / below.sum(), abs=1e-14)


@pytest.mark.parametrize('s', [1.0, 2.0, 4.5])
@pytest.mark.parametrize('n', [3, 4])
def test_equations_a9_and_a17(n, s):
    """Agree with A.9 (2n pixels) and A.17 (2n + 1), the sums from 0 as in A.8 and A.16."""
    for delta in (-0.1, -0.3, -0.49):
        i = np.arange(n)
        pairs = (i - delta) * bell(i - delta, s) - (i + delta + 1) * bell(i + delta + 1, s)
        even = pairs.sum() / bell(np.arange(-n, n) - delta, s).sum()
        last = (n - delta) * bell(n - delta, s)
        odd = (last + pairs.sum()) / bell(np.arange(-n, n + 1) - delta, s).sum()
        sigma = s / np.sqrt(2.0)
        assert skew_error(2 * n, n + delta, sigma, sampled=True) == pytest.approx(even, abs=1e-14)
        assert skew_error(2 * n + 1, n + delta, sigma, sampled=True) == pytest.approx(
            odd, abs=1e-14
        )


def test_it_is_the_error_of_the_centroid():
    """Equal centroid less truth, for many centres at once."""
    centre = np.linspace(3.5, 4.5, 11)
    error = centroid_1d(sampled_profile(9, centre, 2.0)[0]) - centre
    np.testing.assert_allclose(skew_error(9, centre, 2.0, sampled=True), error, atol=1e-14)


@pytest.mark.parametrize('unlit', [False, True])
def test_corrected_centroid_has_no_skew(scene, unlit):
    """Leave a fifth at most of a skew of hundredths of the displacement."""
    noise = SensorNoise(gain=1e9, read_noise=0.5)
    # Four seconds of sigma across the window: 2 sigma to either side.
    shots = scene(9, 2.2, 3000.0, count=2000, noise=noise, unlit=unlit)
    slopes = {}
    for method in ('centroid', 'centroid_skew_corrected'):
        found = shots.locate(method)
        assert found.ok.all()
        slopes[method] = np.polyfit(shots.x - 4.0, found.x - shots.x, 1)[0]
    # Lit only, the tail that the corners take off makes up for half of the skew.
    assert abs(slopes['centroid']) > 0.02
    assert abs(slopes['centroid_skew_corrected']) < 0.004


@pytest.mark.parametrize('unlit', [False, True])
def test_wide_pulse_is_corrected_at_the_bound(scene, unlit):
    """Place a pulse of sigma 2 in 7 x 7, which the plain centroid draws to the middle."""
    noise = SensorNoise(gain=1e9, read_noise=1.0)
    shots = scene(7, 2.0, 60.0, count=2000, noise=noise, unlit=unlit)
    found = shots.locate('centroid_skew_corrected')
    assert found.ok.all()
    assert abs(np.polyfit(shots.x - 3.0, found.x - shots.x, 1)[0]) < 0.02


def test_a_window_without_an_inverse_keeps_its_centroid(scene):
    """Give what the plain centroid gives, and less sure of it."""
    noise = SensorNoise(gain=1e9, read_noise=1.0)
    shots = scene(9, 1.5, 5.0, count=500, noise=noise, unlit=True)
    plain, corrected = shots.locate('centroid'), shots.locate('centroid_skew_corrected')
    kept = plain.ok & (plain.x == corrected.x) & (plain.y == corrected.y)
    assert kept.sum() > 20
    wider = corrected.covariance[kept] - plain.covariance[kept]
    assert (np.trace(wider, axis1=1, axis2=2) > 0.0).all()
    # The difference is a square of one vector: no direction may become surer.
    assert np.linalg.eigvalsh(wider).min() > -1e-9

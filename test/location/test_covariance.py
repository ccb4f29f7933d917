"""The covariance of every method is that of its errors: NEES over thousands of windows."""

from dataclasses import replace

from blob_tracker.location import METHODS
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

NOISE = SensorNoise(gain=4.0, read_noise=1.0)
CASES = [
    # method, options, windows (the simplex takes some 20 ms each)
    ('centroid', {}, 4000),
    ('centroid_skew_corrected', {}, 4000),
    ('multi_gaussian_lm', {}, 1000),
    ('multi_gaussian_lm', {'elliptical': True}, 1000),
    ('multi_gaussian_simplex', {}, 200),
    ('maximum_likelihood', {}, 20000),
    ('maximum_likelihood', {'elliptical': True}, 20000),
]
LOGARITHMIC = ['gaussian_linear', 'gaussian_linear_elliptical']


def nees(errors, covariance):
    """Return the mean normalised squared error; two for a true covariance."""
    return np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariance), errors).mean()


def about_the_mean(errors, shots):
    """Take off the mean error at each sub-pixel place, a cubic of the displacement."""
    middle = (shots.lit.shape[1] - 1) / 2
    trends = [
        np.polyval(np.polyfit(place - middle, error, 3), place - middle)
        for place, error in zip((shots.x, shots.y), errors.T)
    ]
    return errors - np.stack(trends, axis=1)


def test_every_method_has_its_case():
    """Leave no method out."""
    assert {method for method, *_ in CASES} | set(LOGARITHMIC) == set(METHODS)


@pytest.mark.parametrize(('method', 'options', 'count'), CASES)
@pytest.mark.parametrize('unlit', [False, True])
def test_nees(scene, nees_bounds, method, options, count, unlit):
    """Lie in the 95 % bounds; methods with a bias about their mean."""
    shots = scene(9, 1.2, 250.0, count=count, noise=NOISE, unlit=unlit, seed=11)
    found = shots.locate(method, **options)
    assert found.ok.mean() > 0.95
    shots = replace(shots, x=shots.x[found.ok], y=shots.y[found.ok])
    errors = np.stack([found.x[found.ok] - shots.x, found.y[found.ok] - shots.y], axis=1)
    if method != 'maximum_likelihood':
        errors = about_the_mean(errors, shots)
    low, high = nees_bounds(len(errors))
    assert low < nees(errors, found.covariance[found.ok]) < high


@pytest.mark.parametrize('method', LOGARITHMIC)
@pytest.mark.parametrize('weighted', [False, True])
@pytest.mark.parametrize('unlit', [False, True])
def test_nees_of_the_logarithm(scene, method, weighted, unlit):
    """
    Hold within an eighth of two.

    The logarithm of faint pixels has errors far from normal, and the sandwich is consistent
    only as the pixels grow many: the 95 % bounds of 4000 windows, 3 %, are beyond it.
    """
    shots = scene(9, 1.4, 250.0, count=4000, noise=NOISE, unlit=unlit, seed=11)
    found = shots.locate(method, weighted=weighted)
    assert found.ok.all()
    # About one mean: residuals show a misfit that changes with the sub-pixel place as scatter.
    errors = shots.errors(found) - shots.errors(found).mean(axis=0)
    assert 1.75 < nees(errors, found.covariance) < 2.25


@pytest.mark.parametrize('amplitude', [20.0, 50.0, 1000.0])
@pytest.mark.parametrize(('size', 'sigma'), [(7, 1.0), (15, 2.5)])
def test_nees_of_maximum_likelihood_over_signal(scene, nees_bounds, amplitude, size, sigma):
    """Lie in the 95 % bounds of some thousand windows from peak SNR 9 to 60."""
    shots = scene(size, sigma, amplitude, count=2000, noise=NOISE, seed=4)
    found = shots.locate('maximum_likelihood')
    low, high = nees_bounds(int(found.ok.sum()))
    assert low < nees(shots.errors(found), found.covariance[found.ok]) < high


def test_nees_with_clipped_pixels(scene, nees_bounds):
    """Lie in the 95 % bounds where the peak is clipped."""
    shots = scene(
        13, 1.8, 1000.0, count=4000, noise=SensorNoise(gain=40.0, read_noise=1.0), saturation=255
    )
    found = shots.locate('maximum_likelihood')
    low, high = nees_bounds(len(found.x))
    assert found.saturated.min() > 0
    assert low < nees(shots.errors(found), found.covariance) < high


def test_nees_behind_random_texture(scene):
    """Hold the texture that is left: within a quarter of two for white texture of any strength."""
    random = np.random.default_rng(8)
    texture = random.standard_normal((4000, 11, 11))
    for strength in (1.0, 3.0, 10.0):
        shots = scene(
            11, 1.5, 100.0, count=4000, noise=NOISE, background=60.0, unlit=True,
            texture=strength * texture,
        )
        found = shots.locate('maximum_likelihood')
        # The share is estimated from one window: its own scatter is not in the covariance.
        assert 1.75 < nees(shots.errors(found), found.covariance[found.ok]) < 2.5

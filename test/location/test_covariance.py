"""The covariance of every method is that of its errors: NEES over thousands of windows."""

from dataclasses import replace

from blob_tracker.location import locate, METHODS
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation import expose
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(gain=4.0, read_noise=1.0)
CASES = [
    # method, options, windows
    ('centroid', {}, 4000),
    ('centroid_skew_corrected', {}, 4000),
    ('multi_gaussian_lm', {}, 2000),
    ('multi_gaussian_lm', {'elliptical': True}, 2000),
    ('locale_table', {}, 20000),
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
    tested = {method for method, *_ in CASES} | set(LOGARITHMIC) | {'multi_gaussian_simplex'}
    assert tested == set(METHODS)


@pytest.mark.parametrize(('method', 'options', 'count'), CASES)
@pytest.mark.parametrize('unlit', [False, True])
def test_nees(scene, nees_bounds, method, options, count, unlit):
    """Lie in the 95 % bounds; methods with a bias about their mean."""
    shots = scene(9, 1.2, 250.0, count=count, noise=NOISE, unlit=unlit, seed=11)
    found = shots.locate(method, **options)
    assert found.ok.mean() > 0.95
    shots = replace(shots, x=shots.x[found.ok], y=shots.y[found.ok])
    errors = np.stack([found.x[found.ok] - shots.x, found.y[found.ok] - shots.y], axis=1)
    if method not in ('locale_table', 'maximum_likelihood'):
        errors = about_the_mean(errors, shots)
    low, high = nees_bounds(len(errors))
    assert low < nees(errors, found.covariance[found.ok]) < high


@pytest.mark.parametrize('method', LOGARITHMIC)
@pytest.mark.parametrize('weighted', [False, True])
@pytest.mark.parametrize('unlit', [False, True])
def test_nees_of_the_logarithm(scene, nees_bounds, method, weighted, unlit):
    """
    Lie in the 95 % bounds at a peak SNR of 30 and in a window that holds the pulse.

    How far it is off elsewhere is in the docstring of the method.
    """
    shots = scene(11, 1.7, 250.0, count=2000, noise=NOISE, unlit=unlit, seed=11)
    found = shots.locate(method, weighted=weighted)
    assert found.ok.all()
    # About one mean: residuals show a misfit that changes with the sub-pixel place as scatter.
    errors = shots.errors(found) - shots.errors(found).mean(axis=0)
    low, high = nees_bounds(len(errors))
    assert low < nees(errors, found.covariance) < high


def test_nees_of_the_simplex(scene, nees_bounds):
    """Lie in the 95 % bounds of the 1000 windows that 20 ms each leave time for."""
    shots = scene(7, 1.0, 250.0, count=1000, noise=NOISE, unlit=True, seed=11)
    found = shots.locate('multi_gaussian_simplex')
    assert found.ok.all()
    errors = about_the_mean(shots.errors(found), shots)
    low, high = nees_bounds(len(errors))
    assert low < nees(errors, found.covariance) < high


@pytest.mark.parametrize('snr', [50.0, 200.0])
@pytest.mark.parametrize(('size', 'sigma'), [(7, 7 / 6), (9, 1.5), (15, 2.5)])
def test_three_gaussians_settle_where_one_is_enough(scene, size, sigma, snr):
    """Place every window, near the bound's scatter and without an outlier."""
    noise = SensorNoise(gain=1e9, read_noise=1.0)
    amplitude = snr * np.sqrt(1.0 + 1.0 / 12.0)
    shots = scene(size, sigma, amplitude, count=300, noise=noise, seed=3)
    found = shots.locate('multi_gaussian_lm')
    assert found.ok.mean() > 0.99
    errors = about_the_mean(shots.errors(found), replace(
        shots, x=shots.x[found.ok], y=shots.y[found.ok]
    ))
    # Six standard deviations in two dimensions: one in 1e8 of normal errors.
    squares = np.einsum(
        'ni,nij,nj->n', errors, np.linalg.inv(found.covariance[found.ok]), errors
    )
    assert squares.max() < 36.0


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


@pytest.mark.parametrize('method', ['maximum_likelihood', 'multi_gaussian_lm'])
@pytest.mark.parametrize('unlit', [False, True])
def test_nees_of_summed_frames(nees_bounds, unlit, method):
    """Lie in the 95 % bounds for sums of 5 frames whose noise is nearly all read noise."""
    looks, count, size, sigma = 5, 4000, 9, 1.3
    noise = SensorNoise(gain=40.0, read_noise=2.0)
    random = np.random.default_rng(9)
    errors, covariances = [], []
    for x, y in 4.0 + random.uniform(-0.5, 0.5, (count, 2)):
        pulse = 60.0 * np.outer(
            integrated_profile(size, y, sigma)[0], integrated_profile(size, x, sigma)[0]
        )
        lit, dark = (
            expose(np.broadcast_to(mean, (looks, size, size)), noise, random).sum(axis=0)
            for mean in (20.0 + pulse, 20.0 + 0.0 * pulse)
        )
        window = Window(lit, dark if unlit else None, looks=looks)
        found = locate(window, method=method, noise=noise)
        errors.append((found.x - x, found.y - y))
        covariances.append(found.covariance)
    # Told of one frame, multi_gaussian_lm has 5.5; maximum_likelihood, which sees its chi2 of 3
    # and grows the covariance by it, has 1.8 and, with the unlit window, 2.7.
    low, high = nees_bounds(count)
    assert low < nees(np.array(errors), np.array(covariances)) < high


def test_a_window_is_the_sum_of_one_frame_or_more():
    """The number of frames is named where it cannot be."""
    with pytest.raises(ValueError, match='the sum of 0 frames'):
        Window(np.zeros((7, 7)), looks=0)

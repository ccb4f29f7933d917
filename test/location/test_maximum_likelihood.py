"""Maximum likelihood: at the bound, free of bias, and sure of which window to trust."""

from blob_tracker.location import locate, locate_batch
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter


def bound_rms(scene, sigma, amplitude, **options):
    """Return the rms over both axes that the bound allows, averaged over some places."""
    size = scene.lit.shape[1]
    traces = [
        np.trace(cramer_rao_bound(
            (size, size), x=x, y=y, sigma=sigma, amplitude=amplitude, background=20.0,
            noise=scene.noise, **options,
        ))
        for x, y in zip(scene.x[:40], scene.y[:40])
    ]
    return np.sqrt(np.mean(traces))


def rms(errors):
    """Return the rms length of (N, 2) errors."""
    return np.sqrt((errors**2).sum(axis=1).mean())


# Peak SNR 10 to 200: amplitude over 1.04 DN of read noise and rounding.
@pytest.mark.parametrize('amplitude', [10.4, 31.0, 208.0])
@pytest.mark.parametrize(('size', 'sigma'), [(7, 1.0), (9, 1.5), (15, 2.5)])
def test_rms_is_at_the_bound(scene, size, sigma, amplitude):
    """Stay within 1.02 of the Cramer-Rao bound."""
    noise = SensorNoise(gain=1e9, read_noise=1.0)
    shots = scene(size, sigma, amplitude, count=40000, noise=noise)
    found = shots.locate('maximum_likelihood')
    assert found.ok.mean() > 0.995
    # 40000 windows tell the ratio to 0.25 %, one standard deviation.
    assert rms(shots.errors(found)) < 1.02 * bound_rms(shots, sigma, amplitude)


def test_rms_is_at_the_bound_under_shot_noise(scene):
    """Weigh each pixel by its own variance."""
    noise = SensorNoise(gain=0.5, read_noise=1.0)
    shots = scene(9, 1.3, 200.0, count=40000, noise=noise)
    ratio = rms(shots.errors(shots.locate('maximum_likelihood'))) / bound_rms(shots, 1.3, 200.0)
    assert 0.98 < ratio < 1.02


def test_elliptical_pulse(scene):
    """Reach the bound of the six-parameter pulse, and its widths."""
    noise = SensorNoise(gain=4.0, read_noise=1.0)
    shots = scene(13, 1.2, 200.0, sigma_y=2.0, count=20000, noise=noise)
    found = shots.locate('maximum_likelihood', elliptical=True)
    ratio = rms(shots.errors(found)) / bound_rms(shots, 1.2, 200.0, sigma_y=2.0)
    assert 0.98 < ratio < 1.02
    assert np.median(found.sigma) == pytest.approx(np.sqrt(1.2 * 2.0), rel=0.01)


@pytest.mark.parametrize('sigma', [0.7, 1.3, 2.0])
def test_no_bias_against_sub_pixel_phase(scene, sigma):
    """Keep the mean error below 0.005 px in each tenth of a pixel."""
    shots = scene(11, sigma, 1000.0, count=20000, noise=SensorNoise(gain=10.0, read_noise=1.0))
    found = shots.locate('maximum_likelihood')
    phase = np.floor(10.0 * (shots.x - 4.5)).astype(int)
    bias = [np.mean((found.x - shots.x)[phase == tenth]) for tenth in range(10)]
    assert found.ok.all()
    assert np.abs(bias).max() < 0.005


@pytest.mark.parametrize('times', [1.5, 4.0, 8.0])
def test_clipped_peak(scene, times):
    """Stay within 1.3 of the bound of the pixels that are left."""
    noise = SensorNoise(gain=40.0, read_noise=1.0)
    shots = scene(15, 2.0, 255.0 * times, count=10000, noise=noise, saturation=255)
    found = shots.locate('maximum_likelihood')
    assert found.ok.all()
    assert found.saturated.min() > 0
    ratio = rms(shots.errors(found)) / bound_rms(shots, 2.0, 255.0 * times, saturation=255)
    assert ratio < 1.1


def textures(size, count):
    """Return one texture of unit rms of each kind: (size, size) or (count, size, size)."""
    random = np.random.default_rng(3)
    rows, columns = np.mgrid[0:size, 0:size]
    smooth = gaussian_filter(random.standard_normal((count, size + 8, size + 8)), (0, 2, 2))
    smooth = smooth[:, 4:-4, 4:-4]
    return {
        'white': random.standard_normal((count, size, size)),
        'smooth': smooth / smooth.std(),
        'gradient': (columns - (size - 1) / 2) / size * 3.46,
        'edge': np.where(columns > size / 2, 1.0, -1.0),
        'checks': 2.0 * ((rows // 2 + columns // 2) % 2) - 1.0,
    }


@pytest.mark.parametrize('kind', ['white', 'smooth', 'gradient', 'edge', 'checks'])
@pytest.mark.parametrize('strength', [0.0, 1.0, 3.0, 10.0])
def test_texture_never_costs_more_than_the_better_choice(scene, kind, strength):
    """Stay within 1.1 of the better of lit-only and lit minus unlit."""
    noise = SensorNoise(gain=4.0, read_noise=1.5)
    texture = strength * textures(11, 4000)[kind]
    shots = scene(
        11, 1.5, 100.0, count=4000, noise=noise, background=60.0, texture=texture, unlit=True
    )
    found = shots.locate('maximum_likelihood')
    alone = locate_batch(shots.lit, noise=noise)
    difference = np.sqrt(np.mean([
        np.trace(cramer_rao_bound(
            (11, 11), x=x, y=y, sigma=1.5, amplitude=100.0, background=60.0, noise=noise,
            unlit=True,
        ))
        for x, y in zip(shots.x[:40], shots.y[:40])
    ]))
    both = found.ok & alone.ok
    assert found.ok.mean() > 0.995
    chosen = rms(np.stack([found.x - shots.x, found.y - shots.y], axis=1)[both])
    lit_only = rms(np.stack([alone.x - shots.x, alone.y - shots.y], axis=1)[both])
    assert chosen < 1.1 * min(lit_only, difference)


def test_all_parameters_come_back(scene):
    """Return amplitude, background, sigma, SNR and chi2 of the pulse that was drawn."""
    noise = SensorNoise(gain=2.0, read_noise=1.5)
    found = scene(11, 1.4, 150.0, count=2000, noise=noise).locate('maximum_likelihood')
    assert np.median(found.amplitude) == pytest.approx(150.0, rel=0.01)
    assert np.median(found.background) == pytest.approx(20.0, rel=0.01)
    assert np.median(found.sigma) == pytest.approx(1.4, rel=0.01)
    deviation = np.sqrt(170.0 / 2.0 + 1.5**2 + 1.0 / 12.0)
    assert np.median(found.snr) == pytest.approx(150.0 / deviation, rel=0.02)
    assert np.mean(found.chi2) == pytest.approx(1.0, abs=0.02)


def test_locate_is_in_full_frame_coordinates():
    """Shift by the window's place, scale by the binning, grow the covariance with it."""
    noise = SensorNoise(gain=2.0, read_noise=1.5)
    lit = np.rint(pixel_integrated_gaussian((9, 9), 4.2, 3.7, 1.3) * 150.0 + 10.0)
    plain = locate(Window(lit), noise=noise)
    assert plain.x == pytest.approx(4.2, abs=0.01)
    assert plain.y == pytest.approx(3.7, abs=0.01)
    window = Window(lit, x0=300, y0=200, binning=(2, 2), stamp_ns=7)
    placed = locate(window, noise=noise)
    assert placed.x == pytest.approx(300 + 2 * (plain.x + 0.5) - 0.5)
    assert placed.y == pytest.approx(200 + 2 * (plain.y + 0.5) - 0.5)
    np.testing.assert_allclose(placed.covariance, 4.0 * plain.covariance)
    assert placed.stamp_ns == 7


def test_pulse_at_the_edge_of_its_window(scene):
    """Find a pulse of which half is cut off, as well as what is left allows."""
    noise = SensorNoise(gain=4.0, read_noise=1.0)
    shots = scene(17, 1.4, 200.0, count=4000, noise=noise)
    lit = shots.lit[:, :, 8:]
    found = locate_batch(lit, noise=noise)
    bound = np.mean([
        cramer_rao_bound(
            (17, 9), x=x - 8.0, y=y, sigma=1.4, amplitude=200.0, background=20.0, noise=noise
        )[0, 0]
        for x, y in zip(shots.x[:40], shots.y[:40])
    ])
    inside = found.ok & (shots.x - 8.0 > -0.2)
    assert inside.mean() > 0.6
    # The ends of the range trim the scatter a little: no test of efficiency, but of sense.
    assert np.std((found.x - shots.x + 8.0)[inside]) < 1.2 * np.sqrt(bound)


def test_noise_alone_is_not_located():
    """Say so where there is no light; five standard deviations let few through."""
    random = np.random.default_rng(2)
    lit = np.rint(20.0 + 2.0 * random.standard_normal((3000, 11, 11)))
    found = locate_batch(lit, noise=SensorNoise(gain=1e9, read_noise=2.0))
    # The fit looks for the best of some hundred places and widths; five would pass one in 3e6.
    assert found.ok.mean() < 0.003


def test_a_hot_pixel_is_no_target():
    """Refuse a lone bright pixel: its light has no place within the pixel."""
    lit = np.full((9, 9), 10)
    lit[4, 5] = 200
    with pytest.raises(LocationError, match='single pixel'):
        locate(Window(lit), noise=SensorNoise(gain=2.0, read_noise=1.0))


def test_a_misfit_grows_the_covariance():
    """Say less of two pulses than the noise would."""
    noise = SensorNoise(gain=4.0, read_noise=1.0)
    one = 150.0 * pixel_integrated_gaussian((13, 13), 5.0, 6.0, 1.3)
    two = one + 150.0 * pixel_integrated_gaussian((13, 13), 8.5, 6.0, 1.3)
    alone = locate(Window(np.rint(one + 20.0)), noise=noise)
    pair = locate(Window(np.rint(two + 20.0)), noise=noise)
    assert pair.chi2 > 5.0
    assert np.trace(pair.covariance) > 5.0 * np.trace(alone.covariance)

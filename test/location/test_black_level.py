"""A camera with a pedestal: the same estimates as without it, and a true covariance."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location import locate, locate_batch, METHODS
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.location.noise import noise_of_sum, pixel_variance
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest

PEDESTAL = 240.0  # DN
CAMERA = SensorNoise(gain=3.5, read_noise=3.0, black_level=PEDESTAL)
BARE = replace(CAMERA, black_level=0.0)
# In the dark of a scene the ambient light is little beside the pedestal: unaware of it a locator
# gives a background pixel (260 / 3.5 + 9) / (20 / 3.5 + 9) = 5.7 times its variance.
BACKGROUND = PEDESTAL + 20.0
NAMES = ('x', 'y', 'covariance', 'amplitude', 'sigma', 'snr', 'chi2', 'saturated', 'failure')


@pytest.mark.parametrize('unlit', [False, True])
@pytest.mark.parametrize('method', METHODS)
def test_estimates_are_those_without_the_pedestal(scene, method, unlit):
    """Of all methods, with clipped pixels; only the background has the pedestal in it."""
    count = 5 if method == 'multi_gaussian_simplex' else 50
    shots = scene(
        9, 1.2, 400.0, count=count, noise=CAMERA, background=BACKGROUND, unlit=unlit,
        saturation=620,
    )
    found = shots.locate(method)
    bare = locate_batch(
        shots.lit - PEDESTAL, None if shots.unlit is None else shots.unlit - PEDESTAL,
        method=method, noise=BARE, saturation=620 - PEDESTAL,
    )
    assert found.ok.any()
    if method in ('maximum_likelihood', 'multi_gaussian_lm'):
        assert found.saturated.any()
    for name in NAMES:
        # multi_gaussian_lm comes to rest within 1e-6 of a place that rounding picks.
        np.testing.assert_allclose(getattr(found, name), getattr(bare, name), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(found.background, bare.background + PEDESTAL, rtol=1e-6)


@pytest.mark.parametrize('unlit', [False, True])
@pytest.mark.parametrize('method', ['maximum_likelihood', 'gaussian_linear', 'multi_gaussian_lm'])
def test_nees_with_a_pedestal(scene, nees_bounds, method, unlit):
    """Lie in the 95 % bounds."""
    count = 400 if method == 'multi_gaussian_lm' else 4000
    options = {'weighted': True} if method == 'gaussian_linear' else {}
    shots = scene(
        11, 1.7, 400.0, count=count, noise=CAMERA, background=BACKGROUND, unlit=unlit, seed=11
    )
    found = shots.locate(method, **options)
    errors = shots.errors(found)
    errors -= errors.mean(axis=0)
    low, high = nees_bounds(len(errors))
    squares = np.einsum(
        'ni,nij,nj->n', errors, np.linalg.inv(found.covariance[found.ok]), errors
    )
    assert found.ok.mean() > 0.99
    assert low < squares.mean() < high


def test_a_sum_of_looks_carries_the_pedestal_as_often(scene):
    """The window of the sum is located as the sum of windows without a pedestal."""
    shots = [
        scene(9, 1.3, 200.0, count=1, noise=CAMERA, background=BACKGROUND, seed=1).lit[0]
        for _ in range(5)
    ]
    lit = np.asarray(np.sum(shots, axis=0, dtype=np.uint16))
    found = locate(Window(lit, looks=5, saturation=65535), noise=CAMERA)
    bare = locate(Window(lit - 5 * PEDESTAL, looks=5, saturation=65535), noise=BARE)
    assert found.x == pytest.approx(bare.x, abs=1e-9)
    np.testing.assert_allclose(found.covariance, bare.covariance, rtol=1e-9)
    assert found.background == pytest.approx(bare.background + 5 * PEDESTAL)
    # The variance of the sum is the sum of the variances.
    levels = np.array([100.0, 240.0, 260.0, 900.0])
    np.testing.assert_allclose(
        pixel_variance(5 * levels, noise_of_sum(CAMERA, 5)) + 1.0 / 12.0,
        5 * pixel_variance(levels, CAMERA) + 1.0 / 12.0,
    )


@pytest.mark.parametrize('unlit', [False, True])
def test_the_bound_is_that_without_the_pedestal(unlit):
    """Clipped pixels included."""
    pulse = {'x': 5.2, 'y': 4.9, 'sigma': 1.4, 'amplitude': 400.0, 'unlit': unlit}
    np.testing.assert_allclose(
        cramer_rao_bound(
            (11, 11), **pulse, background=BACKGROUND, noise=CAMERA, saturation=550.0
        ),
        cramer_rao_bound(
            (11, 11), **pulse, background=20.0, noise=BARE, saturation=550.0 - PEDESTAL
        ),
        rtol=1e-9,
    )


def test_no_shot_noise_below_the_black_level():
    """A pixel below it has the noise of a dark one."""
    dark = 9.0 + 1.0 / 12.0
    np.testing.assert_allclose(
        pixel_variance(np.array([0.0, 100.0, 240.0, 590.0]), CAMERA),
        [dark, dark, dark, 100.0 + dark],
    )


@pytest.mark.parametrize('wrong', [np.nan, np.inf, -np.inf])
def test_a_black_level_is_finite(wrong):
    """Named in the sentence where it is not."""
    with pytest.raises(ValueError, match='black_level is .*; it must be finite'):
        SensorNoise(3.5, 3.0, wrong)

"""The bound of any model against those of a Gaussian that are known."""

from dataclasses import replace
from functools import partial
from typing import Any

from benchmarks.world import light
from benchmarks.world.bound import bound
from benchmarks.world.situation import BACKGROUND, Model, NOISE, PEAK, SHAPE, SIGMA
from blob_tracker.kernel import Array
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

X, Y = 64.3, 48.2


def known(**options: Any) -> Array:
    """Return the package's bound of the plain light."""
    return cramer_rao_bound(
        SHAPE, x=X, y=Y, sigma=SIGMA, amplitude=PEAK, background=BACKGROUND, noise=NOISE, **options
    )


def test_plain_light() -> None:
    """The same as the analytic derivatives give."""
    np.testing.assert_allclose(bound(light.plain(X, Y)), known(), rtol=1e-5, atol=1e-10)


def test_closed_form_of_constant_noise() -> None:
    """sigma_x = sqrt(2 / pi) / SNR for a well-sampled Gaussian in constant noise."""
    noise = SensorNoise(gain=1e9, read_noise=3.0)
    model = replace(light.plain(X, Y, PEAK, 3.0), noise=noise)
    snr = PEAK / np.sqrt(3.0**2 + 1.0 / 12.0)
    # Pixels of a third of a sigma widen it by 1 / 24 / 3^2: half a per cent.
    np.testing.assert_allclose(
        np.sqrt(np.diag(bound(model))), np.sqrt(2.0 / np.pi) / snr, rtol=0.01
    )


def test_clipped_pixels_tell_nothing() -> None:
    """As in the package's bound with a full scale."""
    model = light.plain(X, Y)
    used = model.mean(model.parameters) < 100.0
    np.testing.assert_allclose(
        bound(replace(model, used=used)), known(saturation=100.0), rtol=1e-5, atol=1e-10
    )


def test_two_images_halve_the_variance() -> None:
    """A stack of two views of the same light is twice the light."""
    model = light.plain(X, Y)
    both = replace(model, mean=lambda parameters: np.stack([model.mean(parameters)] * 2))
    np.testing.assert_allclose(bound(both), bound(model) / 2.0, rtol=1e-6)


def test_what_the_pixels_do_not_show_costs_nothing() -> None:
    """A parameter without effect, and one that only doubles another."""
    model = light.plain(X, Y)
    blind = Model(lambda p: model.mean(p[:-1]), np.append(model.parameters, 5.0))
    np.testing.assert_allclose(bound(blind), bound(model), rtol=1e-6)
    twice = Model(
        lambda p: model.mean(p[:-1]) + p[-1], np.append(model.parameters, 0.0)
    )
    np.testing.assert_allclose(bound(twice), bound(model), rtol=1e-4)


def test_gaussians_hold_their_light() -> None:
    """2 pi sigma^2 of each, at any phase, and the middle where it is said."""
    picture = light.gaussians(SHAPE, [X, 40.0], [Y, 30.4], [SIGMA, 0.4], [100.0, 50.0])
    light_of_both = 2.0 * np.pi * (100.0 * SIGMA**2 + 50.0 * 0.4**2)
    assert picture.sum() == pytest.approx(light_of_both, rel=1e-9)
    alone = light.gaussians(SHAPE, X, Y, SIGMA)
    assert (alone.sum(axis=0) * np.arange(SHAPE[1])).sum() / alone.sum() == pytest.approx(X)


@pytest.mark.parametrize('hole', [0.0, 0.5])
def test_a_ring_has_its_area(hole: float) -> None:
    """Hold pi R^2 (1 - hole^2): the blur of an edge moves light, and adds pi sigma^2."""
    picture = light.ring(SHAPE, X, Y, 6.0, hole, 0.7)
    area = np.pi * 6.0**2 * (1.0 - hole**2) + (np.pi * 0.7**2 if hole == 0.0 else 0.0)
    assert picture.sum() == pytest.approx(area, rel=1e-3)
    rows, columns = np.indices(SHAPE)
    assert (picture * columns).sum() / picture.sum() == pytest.approx(X, abs=1e-3)
    assert (picture * rows).sum() / picture.sum() == pytest.approx(Y, abs=1e-3)


def test_places_have_all_phases() -> None:
    """Resting lights over two pixels, still within a pair; circling ones at speed."""
    random = np.random.default_rng(7)
    places = light.resting(4000, random)
    assert (places[1:-1:2] == places[2::2]).all()  # an unlit frame and the lit one after it
    for phase in (places[::2] % 1.0).T:
        counts, _ = np.histogram(phase, 10, (0.0, 1.0))
        assert counts.min() > 150  # of 200 +- 13
    steps = np.hypot(*np.diff(light.circling(100, random, 0.8), axis=0).T)
    assert steps == pytest.approx(0.8, rel=1e-3)


def test_texture_goes_on_beyond_its_edges() -> None:
    """Mean 0, deviation 1, and neighbours across the edge as alike as any."""
    field = light.smooth_field(SHAPE, 1.5, np.random.default_rng(7))
    assert (field.mean(), field.std()) == pytest.approx((0.0, 1.0), abs=1e-9)
    within = np.abs(np.diff(field, axis=1)).mean()
    assert np.abs(field[:, 0] - field[:, -1]).mean() == pytest.approx(within, rel=0.3)


def test_partial_models_can_be_bounded() -> None:
    """A narrow light is bounded too, if worse in the middle of a pixel."""
    narrow = partial(light.plain, sigma=0.3)
    middle, corner = (np.trace(bound(narrow(x, x))) for x in (48.0, 48.5))
    assert 0.0 < corner < middle

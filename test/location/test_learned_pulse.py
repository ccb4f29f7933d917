"""The learned pulse against pulses that no Gaussian fits, and against its bound."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from blob_tracker.location import EffectivePsf, learn_pulse, locate_batch, method_options
from blob_tracker.location.estimates import Failure
from blob_tracker.types import LocationError
import numpy as np
import pytest
from support.pulses import BACKGROUND, bound, drawn, NOISE, PEAK, shots, windows

COUNT = 250
PULSES = {
    'disc': (15, lambda u, v: np.hypot(u, v) < 4.0),
    'ring': (15, lambda u, v: (np.hypot(u, v) < 4.5) & (np.hypot(u, v) > 3.0)),
    'Moffat': (11, lambda u, v: (1.0 + (u**2 + v**2) / 1.2**2) ** -2.5),
}


@pytest.mark.parametrize('name', PULSES)
def test_a_pulse_that_is_no_gaussian_is_placed_at_its_bound(name: str) -> None:
    """Learned from 250 windows: 1.1 times the bound and a true covariance on 250 others."""
    side, intensity = PULSES[name]
    pulse = drawn(side, intensity)
    lit, unlit, _ = windows(pulse, side, 1, COUNT)
    learned = learn_pulse([(lit, unlit)], noise=NOISE)
    lit, unlit, places = windows(pulse, side, 2, COUNT)
    found = locate_batch(lit, unlit, noise=NOISE, pulse=learned.pulse)
    assert found.ok.all()
    errors = np.stack([found.x, found.y], axis=1) - places
    rms = float(np.sqrt(np.mean(errors**2)))
    # An rms of 500 errors is known to 3 %.
    assert rms < 1.1 * bound(pulse, side) * 1.06
    nees = np.einsum('ni,nij,nj->n', errors, np.linalg.inv(found.covariance), errors)
    assert 1.4 < nees.mean() < 2.8
    assert learned.gain > 0.0
    assert learned.windows > 0.95 * COUNT
    # The centre is the middle of a round pulse, to what 250 windows tell.
    assert np.abs(errors.mean(axis=0)).max() < 4.0 * bound(pulse, side) / np.sqrt(COUNT) * 2.0


def test_the_same_windows_have_the_same_pulse() -> None:
    """Nothing is drawn at random."""
    side, intensity = PULSES['Moffat']
    lit, unlit, _ = windows(drawn(side, intensity), side, 3, 150)
    first, second = (learn_pulse([(lit, unlit)], noise=NOISE) for _ in range(2))
    assert (first.pulse.coefficients == second.pulse.coefficients).all()


def gaussian(count: int = 61, step: float = 0.5, sigma: float = 1.5) -> EffectivePsf:
    """Return the coefficients that make a Gaussian, nearly: a spline of its values."""
    along = (np.arange(count) - count // 2) * step
    bell = np.exp(-0.5 * (along / sigma) ** 2)
    surface = np.outer(bell, bell)
    pulse = EffectivePsf(surface, step, sigma)
    return replace(pulse, coefficients=surface / pulse.value(0.0, 0.0))


def test_it_grows_and_shrinks_with_the_blob() -> None:
    """A blob a fifth larger, or smaller, is placed and its sigma told."""
    pulse = gaussian()
    random = np.random.default_rng(4)
    for scale in (0.8, 1.2):
        mean = np.stack([
            BACKGROUND + PEAK * pulse.image((15, 15), 7.3, 6.9, scale) for _ in range(50)
        ])
        found = locate_batch(shots(random, mean), noise=NOISE, pulse=pulse)
        assert found.ok.all()
        assert np.median(found.sigma) == pytest.approx(1.5 * scale, rel=0.01)
        assert found.x.mean() == pytest.approx(7.3, abs=0.02)
        assert found.y.mean() == pytest.approx(6.9, abs=0.02)


def test_slopes_are_those_of_the_pulse() -> None:
    """What the fit takes for derivatives are differences of its images."""
    pulse = gaussian()
    along = np.linspace(-4.0, 4.0, 17)
    middle = pulse.value(along, 0.3)
    apart = pulse.value(along + 1e-5, 0.3) - pulse.value(along - 1e-5, 0.3)
    assert middle == pytest.approx(pulse.value(-along, 0.3), abs=1e-12)
    width2 = 1.5**2 + 0.5**2 / 3.0  # that of a cubic spline is a third of the square of its step
    assert apart / 2e-5 == pytest.approx(-along / width2 * middle, abs=0.02)


def test_the_gaussian_goes_on_where_the_pulse_does_not_fit() -> None:
    """A pulse of a much larger light is not forced upon a small one."""
    pulse = gaussian(sigma=5.0)
    random = np.random.default_rng(5)
    span = np.arange(11) - 5.0
    bell = np.exp(-0.5 * (span / 1.0) ** 2)
    lit = shots(random, np.repeat(BACKGROUND + PEAK * np.outer(bell, bell)[None], 20, axis=0))
    with_pulse = locate_batch(lit, noise=NOISE, pulse=pulse)
    alone = locate_batch(lit, noise=NOISE)
    assert with_pulse.ok.all()
    assert with_pulse.x == pytest.approx(alone.x)


def test_too_little_is_refused() -> None:
    """Too few windows, faint ones, and windows in one phase."""
    side, intensity = PULSES['Moffat']
    pulse = drawn(side, intensity)
    lit, unlit, _ = windows(pulse, side, 6, 60)
    with pytest.raises(LocationError, match='60 windows .* too few .* takes 100'):
        learn_pulse([(lit, unlit)], noise=NOISE)
    with pytest.raises(LocationError, match='0 windows .* too few'):
        learn_pulse([(unlit, unlit)], noise=NOISE)
    random = np.random.default_rng(7)
    still = np.stack([BACKGROUND + PEAK * pulse(5.1, 5.0 + k / 120.0) for k in range(120)])
    with pytest.raises(LocationError, match='of the pixel without a centre along x'):
        learn_pulse([(shots(random, still), None)], noise=NOISE)


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        ({'coefficients': np.ones((6, 6))}, 'n odd'),
        ({'coefficients': np.zeros((9, 9))}, 'peak'),
        ({'coefficients': np.full((9, 9), np.nan)}, 'within 1000'),
        ({'step': 0.0}, 'step'),
        ({'sigma': -1.0}, 'sigma'),
        ({'covariance': -np.eye(2)}, 'negative variance'),
    ],
)
def test_an_impossible_pulse_is_refused(changes: dict[str, Any], sentence: str) -> None:
    """With what is wrong about it."""
    with pytest.raises(ValueError, match=sentence):
        replace(gaussian(), **changes)


def test_only_maximum_likelihood_takes_a_pulse() -> None:
    """The others say so."""
    pulse = gaussian()
    assert method_options('maximum_likelihood', pulse=pulse) == {'pulse': pulse}
    with pytest.raises(ValueError, match="'centroid' takes no learned pulse"):
        method_options('centroid', pulse=pulse)


def test_a_place_that_is_vaguer_than_the_pulse_is_none() -> None:
    """Of an undersampled light whose size is free, as where the Gaussian is fitted."""
    pulse, random = gaussian(step=0.25, sigma=0.5), np.random.default_rng(6)
    places = random.uniform(3.0, 7.0, (400, 2))
    mean = np.stack([BACKGROUND + 20.0 * pulse.image((11, 11), x, y) for x, y in places])
    lit = shots(random, mean)
    found, alone = (locate_batch(lit, noise=NOISE, pulse=each) for each in (pulse, None))
    for each in (found, alone):
        assert (each.failure == Failure.VAGUE).sum() > 40
        widest = np.maximum(each.covariance[:, 0, 0], each.covariance[:, 1, 1])[each.ok]
        assert (widest < 8.0 * each.sigma[each.ok] ** 2).all()
    wrong = (found.x - places[:, 0])[found.ok] ** 2 / found.covariance[found.ok, 0, 0]
    assert np.mean(wrong > 25.0) == 0.0

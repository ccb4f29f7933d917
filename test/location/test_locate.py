"""One window in one compiled call: as in a stack, and not where anything is odd about it."""

from dataclasses import replace
from importlib import import_module
from typing import Any

from blob_tracker.location import locate_batch
from blob_tracker.location.locate import estimate, single
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(20.0, 1.5, 12.0)
METHOD = 'maximum_likelihood'


def _window(random: np.random.Generator, **changed: Any) -> Window:
    """Return a light of some place before a slope."""
    x, y = random.uniform(5.0, 7.0, 2)
    rows, columns = np.mgrid[:13, :13]
    pulse = 120.0 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / 4.5)
    unlit = 40.0 + columns
    noisy = [np.rint(random.normal(each, np.sqrt(each / 20.0 + 2.0))) for each in
             (unlit + pulse, unlit)]
    lit, unlit = (each.astype(np.uint8) for each in noisy)
    return replace(Window(lit, unlit, saturation=255), **changed)


@pytest.mark.parametrize('changed', [
    {}, {'unlit': None}, {'binning': (1, 2)}, {'looks': 3}, {'added_noise': 0.7},
    {'saturation': 140}, {'saturation': None},
])
def test_one_is_placed_as_a_stack_of_one(changed: dict[str, Any]) -> None:
    """To the last bit, whatever the window is."""
    random = np.random.default_rng(3)
    for _ in range(40):
        window = _window(random, **changed)
        found = single(window, method=METHOD, noise=NOISE)
        other = estimate(window, method=METHOD, noise=NOISE).first()
        assert found.covariance.tolist() == other.covariance.tolist()
        assert found._replace(covariance=other.covariance, lopsided=list(found.lopsided)) == other


def test_nothing_is_fitted_twice_where_nothing_is_odd(monkeypatch: pytest.MonkeyPatch) -> None:
    """The texture behind the light is nothing that is odd."""
    window = _window(np.random.default_rng(4))
    stacked = []
    rooms = import_module('blob_tracker.location.maximum_likelihood')
    monkeypatch.setattr(rooms, 'fit_gaussians', lambda *_, **__: stacked.append(1))
    single(window, method=METHOD, noise=NOISE)
    assert not stacked


@pytest.mark.parametrize('lit, reason', [
    (np.full((9, 9), 50), 'flat'), (np.full((9, 9), np.nan), 'NaN'), (np.eye(2), 'at least 3 x 3'),
    (np.ones(9), 'must have 2'), (np.full((9, 9), 1j), 'real numbers'), ([[1, 2], [3]], 'array'),
])
def test_what_is_no_window_is_refused_as_in_a_stack(lit: Any, reason: str) -> None:
    """With the same words."""
    with pytest.raises(LocationError, match=reason):
        single(Window(lit), method=METHOD, noise=NOISE)
    with pytest.raises(LocationError, match=reason):
        estimate(Window(lit), method=METHOD, noise=NOISE).first()


def test_lit_and_unlit_of_other_sizes_are_refused() -> None:
    """Before any is looked at."""
    with pytest.raises(LocationError, match='must be equal'):
        single(Window(np.ones((9, 9)), np.ones((9, 8))), method=METHOD, noise=NOISE)
    assert not locate_batch(np.ones((1, 9, 9)), noise=NOISE).ok.any()

"""What the last flashes say of the next outdoes how rare a model is, and never the pixels."""

from __future__ import annotations

from blob_tracker.location.estimates import Beside
from blob_tracker.location.hypotheses import choose, Fit, History, LEAST_BELIEF
import numpy as np
import pytest

PIXELS = 450


def fit(model: str, log_likelihood: float, parameters: int = 8) -> Fit:
    """Return a fit with its place to 0.02 px."""
    return Fit(
        0.0, 0.0, 4e-4 * np.eye(2), 100.0, 30.0, 1.5, 50.0, 1.0, log_likelihood, parameters,
        model=model,
    )


BASE = fit('', 0.0, parameters=5)


def test_nothing_is_known_before_the_first_flash() -> None:
    """What is rare is so."""
    assert History().belief('streak') == 0.0
    assert History().belief('two_lights', 3.0) == -3.0
    assert not History().is_certain('two_lights')


def test_a_model_that_led_pays_for_its_rarity_once() -> None:
    """And one that fell behind may be the true one of another light."""
    told = [{'two_lights': 0.0, 'streak': -1.0}] * 30
    history = History(evidence=told)
    assert history.belief('two_lights', 3.0) == 0.0
    assert history.belief('streak') == LEAST_BELIEF
    assert history.is_certain('two_lights') and not history.is_certain('streak')
    few = History(evidence=told[:4])
    assert few.belief('two_lights', 3.0) == -3.0
    assert few.belief('streak') == pytest.approx(-4.0)


@pytest.mark.parametrize('flashes, sigma', [(0, 0.02), (4, 0.02), (30, 1.0)])
def test_a_second_light_that_is_not_told_apart_is_in_the_covariance(
    flashes: int, sigma: float
) -> None:
    """The target is one of the two, half of the way between them from where a streak is."""
    history = History(
        evidence=[{'two_lights': 0.0, 'streak': -1.0}] * flashes,
        beside=Beside(np.array([2.0, 0.0]), 1.0) if flashes else None,
    )
    chosen = choose(BASE, [fit('streak', 80.0)], PIXELS, history)
    assert chosen.model == 'streak'
    assert chosen.covariance[0, 0] == pytest.approx(sigma**2, rel=0.01)
    assert chosen.covariance[1, 1] == pytest.approx(4e-4)

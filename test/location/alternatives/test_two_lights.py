"""Two lights that flash in step and are merged are told apart."""

from __future__ import annotations

from blob_tracker.location.alternatives.two_lights import two_lights
from blob_tracker.location.hypotheses import History, Motion, Pair
from blob_tracker.location.locator import Locator
from blob_tracker.location.pair_model import one_pulse, to_fit
from blob_tracker.simulation import expose
from blob_tracker.types import Window
import numpy as np
import pytest
from support.lights import BACKGROUND, located, NOISE, pulse

DIRECTION = np.array([0.8, 0.6])


@pytest.mark.parametrize('distance, part, where', [
    (4.5, 0.5, 'below and right of'), (6.0, 0.5, 'below and right of'),
])
def test_the_brighter_one_is_the_target(distance: float, part: float, where: str) -> None:
    """And the other one is spoken of."""
    def light(shape: tuple[int, int], x: float, y: float) -> np.ndarray:
        away = distance * DIRECTION
        return pulse(shape, x, y) + part * pulse(shape, x + away[0], y + away[1])

    result = located(light, 19, 40)
    # 0.02 px at these levels with one light: a second one costs a third of that.
    assert result.rms < 0.03
    assert 1.3 < result.nees < 2.9
    assert result.said('a second light') > 0.95
    assert result.said(where) > 0.9


@pytest.mark.parametrize('expected', [0, 1])
def test_of_two_equal_ones_the_expected_one_is_the_target(expected: int) -> None:
    """Where the last flashes say where it should be."""
    random = np.random.default_rng(3)
    places = np.array([[7.2, 8.1], [9.6, 9.9]])
    lit = np.sum([pulse((18, 18), x, y) for x, y in places], axis=0) + BACKGROUND
    motion = Motion(np.zeros(2), 0.15, places[expected] + 0.2)
    pair = Pair(
        expose(lit, NOISE, random).astype(float),
        expose(np.full(lit.shape, BACKGROUND), NOISE, random).astype(float), NOISE, np.inf,
        History(motion),
    )
    base = one_pulse(pair, np.array([8.4, 9.0, 100.0, 30.0, 2.0]))
    assert base is not None
    fit = two_lights(pair, to_fit(pair, base))
    assert fit is not None
    # Five of its standard deviations, of 0.03 px.
    assert np.hypot(*(np.array([fit.x, fit.y]) - places[expected])) < 0.15


@pytest.mark.parametrize('distance, part', [(3.5, 0.8), (5.0, 0.3), (4.0, 1.0)])
def test_the_target_stays_the_same_of_the_two(distance: float, part: float) -> None:
    """
    Though noise makes now the one brighter, now the other, and the light is anywhere.

    Together the flashes tell which one is brighter; of equal ones it stays the first.
    """
    random = np.random.default_rng(21)
    locator = Locator()
    chosen = []
    for index in range(70):
        x, y = 9.5 + random.uniform(-1.0, 1.0, 2)
        places = np.array([[x, y], [x, y] + distance * DIRECTION])
        lit = BACKGROUND + pulse((21, 21), *places[0]) + part * pulse((21, 21), *places[1])
        location = locator.locate(
            Window(
                expose(lit, NOISE, random), expose(np.full(lit.shape, BACKGROUND), NOISE, random),
                0, 0, round(index * 1e9 / 30), 255,
            ),
            noise=NOISE,
        )
        away = np.hypot(*(np.array([location.x, location.y]) - places).T)
        # Five standard deviations of 0.04 px.
        assert away.min() < 0.2
        chosen.append(int(away.argmin()))
    assert len(set(chosen[10:])) == 1
    assert part == 1.0 or chosen[-1] == 0

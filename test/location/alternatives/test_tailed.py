"""A light with a tail is placed at its head, or the covariance says how far it may be off."""

from __future__ import annotations

from blob_tracker.location.locator import Locator
from blob_tracker.simulation import expose
from blob_tracker.types import Window
import numpy as np
from support.lights import BACKGROUND, dragged, located, NOISE, pulse

WAY = np.array([3.2, 2.4])  # px


def light_with(part: float, shape: tuple[int, int], x: float, y: float) -> np.ndarray:
    """Return a pulse of which a part is on the way."""
    return (1.0 - part) * pulse(shape, x, y) + part * dragged(shape, x, y, WAY)


def test_a_strong_tail_is_a_model() -> None:
    """Of 40 % it is told from the head."""
    result = located(lambda *place: light_with(0.4, *place), 17, 40)
    assert 1.2 < result.nees < 2.9
    assert result.said('tail') > 0.95


def test_a_weak_tail_is_seen_over_some_flashes() -> None:
    """Of 16 % it is hardly seen in one window, and moves the place by six sigmas."""
    random = np.random.default_rng(11)
    locator = Locator()
    squares, warned = [], 0
    for flash in range(60):
        x, y = 6.0 + random.uniform(-0.5, 0.5, 2)
        lit = expose(light_with(0.16, (13, 13), x, y) + BACKGROUND, NOISE, random)
        unlit = expose(np.full((13, 13), BACKGROUND), NOISE, random)
        window = Window(lit, unlit, stamp_ns=flash * 33_000_000)
        location = locator.locate(window, noise=NOISE)
        error = np.array([location.x - x, location.y - y])
        if flash >= 5:
            squares.append(error @ np.linalg.solve(location.covariance, error))
            warned += 'lopsided' in location.warning or 'tail' in location.warning
    assert np.mean(squares) < 2.8
    assert warned > 50

"""A light that is dragged along a line is placed at the line's middle."""

from __future__ import annotations

import numpy as np
import pytest
from support.lights import dragged, located, PEAK


@pytest.mark.parametrize('length, degrees, bound', [
    # The bound along one axis, by the Fisher information of a streak of unknown length and angle.
    (4.0, 0.0, 0.0192), (8.0, 30.0, 0.0188), (14.0, 45.0, 0.0178), (20.0, 90.0, 0.0176),
])
def test_a_streak_has_its_middle(length: float, degrees: float, bound: float) -> None:
    """Its covariance is true, and it says how long it is."""
    angle = np.radians(degrees)
    way = length * np.array([np.cos(angle), np.sin(angle)])

    def light(shape: tuple[int, int], x: float, y: float) -> np.ndarray:
        streak = dragged(shape, x - 0.5 * way[0], y - 0.5 * way[1], way)
        return streak * PEAK / streak.max()

    result = located(light, int(length) + 13, 40)
    # Of 80 errors: the rms is known to 8 %, the NEES to 0.3.
    assert result.rms < 1.25 * bound
    assert 1.1 < result.nees < 2.9
    assert np.mean(result.found.chi2) == pytest.approx(1.0, abs=0.1)
    assert result.said(f'a streak of {length:.0f} px') > 0.8


def test_a_pulse_of_two_widths_is_no_streak_to_speak_of() -> None:
    """It fits, at any angle, and nobody is told to shorten the exposure."""
    def light(shape: tuple[int, int], x: float, y: float) -> np.ndarray:
        rows, columns = np.indices(shape)
        along = (columns - x + rows - y) / np.sqrt(2)
        across = (columns - x - rows + y) / np.sqrt(2)
        return PEAK * np.exp(-0.5 * ((along / 2.0) ** 2 + (across / 1.75) ** 2))

    result = located(light, 15, 40)
    assert 1.3 < result.nees < 2.9
    assert result.said('streak') < 0.3

"""A light that is switched while its lines are read stands higher in the one frame."""

from __future__ import annotations

from blob_tracker.segmentation.line_shift import no_shift, take_rows
import numpy as np
import pytest

NOISE = 0.05  # px, of a place


def is_seen(shift: float, path: np.ndarray, count: int = 48, noise: float = NOISE) -> bool:
    """Show the places of so many flashes; `path` has one a frame, unlit before lit."""
    random = np.random.default_rng(4)
    memory = no_shift()
    for index in range(count):
        unlit, lit = path[2 * index:2 * index + 2] + random.normal(0.0, noise, 2)
        seen = take_rows(memory, lit, unlit + shift, True)
    return seen


@pytest.mark.parametrize('shift', [0.15, -0.3, 1.2])
def test_a_shift_is_seen(shift: float) -> None:
    """It is known to 0.05 sqrt(2 / 48) = 0.01 px of a light that shakes."""
    shaking = np.repeat(np.random.default_rng(1).uniform(-1.0, 1.0, 48), 2)
    assert is_seen(shift, shaking)


@pytest.mark.parametrize('path', [
    np.zeros(96), 0.7 * np.arange(96), 0.02 * np.arange(96) ** 2,
    60.0 * np.sin(np.arange(96) * 8.0 / 60.0),
], ids=['rests', 'moves', 'speeds up', 'swings'])
def test_motion_is_no_shift(path: np.ndarray) -> None:
    """However it moves."""
    assert not is_seen(0.0, path)


def test_few_flashes_tell_nothing() -> None:
    """Nor do those in which the light is in the lit frame alone."""
    assert not is_seen(1.0, np.zeros(96), count=11)
    memory = no_shift()
    assert not any(take_rows(memory, 3.0, 4.0, False) for _ in range(40))


@pytest.mark.parametrize('path', [np.zeros(96), np.arange(96.0)], ids=['rests', 'moves'])
def test_without_noise_the_motion_tells_no_constant(path: np.ndarray) -> None:
    """Speed and bend are none, or the same in each flash: nothing is known of a shift."""
    assert not is_seen(1.0, path, noise=0.0)

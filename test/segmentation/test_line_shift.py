"""A light that is switched while its lines are read stands higher in the one frame."""

from __future__ import annotations

from blob_tracker.segmentation.line_shift import LineShift
import numpy as np
import pytest

NOISE = 0.05  # px, of a place


def watched(shift: float, path: np.ndarray, count: int = 48) -> LineShift:
    """Show the places of so many flashes; `path` has one a frame, unlit before lit."""
    random = np.random.default_rng(4)
    watch = LineShift()
    for index in range(count):
        unlit, lit = path[2 * index:2 * index + 2] + random.normal(0.0, NOISE, 2)
        watch.add(lit, unlit + shift)
    return watch


@pytest.mark.parametrize('shift', [0.15, -0.3, 1.2])
def test_a_shift_is_seen(shift: float) -> None:
    """It is known to 0.05 sqrt(2 / 48) = 0.01 px of a light that shakes."""
    shaking = np.repeat(np.random.default_rng(1).uniform(-1.0, 1.0, 48), 2)
    assert watched(shift, shaking).seen


@pytest.mark.parametrize('path', [
    np.zeros(96), 0.7 * np.arange(96), 0.02 * np.arange(96) ** 2,
    60.0 * np.sin(np.arange(96) * 8.0 / 60.0),
], ids=['rests', 'moves', 'speeds up', 'swings'])
def test_motion_is_no_shift(path: np.ndarray) -> None:
    """However it moves."""
    assert not watched(0.0, path).seen


def test_few_flashes_tell_nothing() -> None:
    """Nor do those in which the light is in the lit frame alone."""
    assert not watched(1.0, np.zeros(96), count=11).seen
    watch = LineShift()
    for _ in range(40):
        watch.add(3.0, None)
    assert not watch.seen


def test_it_is_judged_from_the_twelfth_flash_on() -> None:
    """Before that nobody knows whether the lines are cut."""
    assert not watched(0.0, np.zeros(96), count=11).judged
    assert watched(0.0, np.zeros(96), count=16).judged

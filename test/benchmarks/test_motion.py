"""Errors from a moving camera are those of the target, paired with those of a still one."""

from __future__ import annotations

from dataclasses import replace

from benchmarks import motion
from benchmarks.clutter import with_target
import numpy as np
import pytest

SCENE = with_target(motion.WALL, 50.0, motion.SIGMA)


def test_camera_moves_as_fast_as_said() -> None:
    """5 px a frame, whatever the frame."""
    for camera in motion.CAMERAS.values():
        scene = replace(SCENE, camera=camera)
        middle = (159.5, 119.5)
        places = np.array([scene.shot(index).place(*middle) for index in range(100)])
        assert np.hypot(*np.diff(places, axis=0).T) == pytest.approx(5.0, rel=0.01)


def test_still_errors_are_those_of_the_noise() -> None:
    """About sqrt(2 / pi) / 50 = 0.016 px, the bound of a well-sampled blob at SNR 50."""
    errors = motion.errors(SCENE, 'none', 44)
    assert errors.shape == (16, 2)
    assert np.isfinite(errors).all()
    assert 0.005 < np.sqrt((errors**2).mean()) < 0.03


def test_what_was_not_placed_is_left_out_of_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """And counted."""
    still = np.full((4, 2), 0.1)
    moving = np.array([[0.2, 0.2], [0.2, 0.2], [np.nan, np.nan], [0.2, 0.2]])
    monkeypatch.setattr(
        motion, 'errors', lambda scene, registration, count: still
        if scene.camera is None else moving
    )
    rows = motion.run(8, lambda _: None)
    assert len(rows) == motion.steps()
    for row in rows:
        assert row.ratio == pytest.approx(2.0)
        assert (row.still, row.moving) == pytest.approx((0.1, 0.2))
        assert (row.lit, row.found_still, row.found_moving) == (4, 4, 3)

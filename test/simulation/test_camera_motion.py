"""Cameras move as fast as they are said to."""

from blob_tracker.simulation import Drifting, Stepping
import numpy as np
import pytest

SHAPE = (240, 320)
MIDDLE = np.array([159.5, 119.5, 1.0])


def test_a_circle_has_the_same_speed_everywhere() -> None:
    """The chord of a step is the arc but for a quarter of a per cent."""
    camera = Drifting(5.0, radius=30.0, turn=1.0)
    places = np.array([camera.motion(index, SHAPE) @ MIDDLE for index in range(200)])
    steps = np.diff(places, axis=0)
    assert np.hypot(*steps.T) == pytest.approx(5.0, rel=0.0025)
    directions = np.arctan2(steps[:, 1], steps[:, 0])
    assert np.ptp(directions) > 6.0


def test_turn_and_shake_reach_as_far_as_said() -> None:
    """Degrees to either side, and pixels beside the circle."""
    camera = Drifting(1.0, radius=30.0, shake=2.0, turn=1.5)
    motions = np.array([camera.motion(index, SHAPE) for index in range(400)])
    turns = np.degrees(np.arctan2(motions[:, 0, 1], motions[:, 0, 0]))
    assert np.abs(turns).max() == pytest.approx(1.5, abs=0.01)
    places = motions @ MIDDLE - MIDDLE[:2]
    beside = np.abs(np.hypot(*places.T) - 30.0)
    assert 1.8 < beside.max() < 2.0 * np.sqrt(2.0)


def test_stepping_has_moved_in_the_even_frames() -> None:
    """And is at rest in the odd ones."""
    camera = Stepping(3.0, -2.0, turn=4.0)
    assert camera.motion(1, SHAPE) == pytest.approx(np.eye(2, 3))
    assert camera.motion(2, SHAPE) @ MIDDLE == pytest.approx(MIDDLE[:2] + (3.0, -2.0))

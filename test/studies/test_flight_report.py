"""The picture of a flight."""

from pathlib import Path

from blob_tracker.studies.flight_report import draw_flight
import cv2
import numpy as np
from scipy.spatial.transform import Rotation


def test_a_flight_of_two_poses_is_drawn(tmp_path: Path) -> None:
    """However few there are; it is no blank page."""
    turns = Rotation.from_euler('xyz', [[0.0, 0.1, 0.2], [0.3, 0.1, 0.0]])
    places = np.array([[0.0, 0.0, 1.5], [0.2, 0.1, 1.8]])
    draw_flight(
        tmp_path / 'flight.png', np.array([0.0, 0.1]), places, turns, places + 1e-3, turns,
        np.full((2, 6), 1e-3), np.tile(1e-6 * np.eye(6), (2, 1, 1)), 0.2 * np.eye(3),
    )
    picture = cv2.imread(str(tmp_path / 'flight.png'))
    assert picture.shape[1] >= 1000
    assert (picture < 128).mean() > 0.002

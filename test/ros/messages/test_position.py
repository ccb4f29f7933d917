"""The messages of a position: metres, its covariance, and a turn that nobody knows."""

from blob_tracker.ros.messages.position import point_message, pose_message
from blob_tracker.tracking.triangulation import Position
import numpy as np
import pytest

COVARIANCE = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
POSITION = Position(np.array([1.0, 2.0, 3.0]), COVARIANCE, np.zeros((3, 3)), 0.5, 1, 1_500_000_000)


def test_point_is_in_metres() -> None:
    """With the stamp and the frame."""
    message = point_message(POSITION, 'map')
    assert (message.point.x, message.point.y, message.point.z) == (1.0, 2.0, 3.0)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert message.header.frame_id == 'map'


def test_pose_has_the_covariance_and_no_orientation() -> None:
    """The turns about all three axes are spread over the circle."""
    message = pose_message(POSITION, 'map')
    covariance = np.array(message.pose.covariance).reshape(6, 6)
    np.testing.assert_array_equal(covariance[:3, :3], COVARIANCE)
    assert covariance[3:, 3:].diagonal() == pytest.approx(3 * [np.pi**2 / 3])
    assert np.count_nonzero(covariance) == 12
    turn = message.pose.pose.orientation
    assert (turn.x, turn.y, turn.z, turn.w) == (0.0, 0.0, 0.0, 1.0)
    place = message.pose.pose.position
    assert (place.x, place.y, place.z) == (1.0, 2.0, 3.0)

"""The messages of a body's pose and twist: metres, radians, fixed axes, in the order of ROS."""

from __future__ import annotations

from blob_tracker.constellation import Pose
from blob_tracker.ros.messages.body import body_pose_message, body_twist_message, quaternion
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

TURN = Rotation.from_euler('xyz', [0.3, -0.7, 2.0])
SQUARE = np.arange(36.0).reshape(6, 6)
POSE = Pose(
    TURN.as_matrix(), np.array([1.0, 2.0, 3.0]), SQUARE, np.arange(6.0), SQUARE[::-1], 0.5, 4, (),
    1_500_000_000,
)


def test_pose_is_that_of_ros() -> None:
    """Body's frame to header's, w >= 0; the covariance row by row."""
    message = body_pose_message(POSE, 'optical')
    assert message.header.frame_id == 'optical'
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    assert (place.x, place.y, place.z) == (1.0, 2.0, 3.0)
    np.testing.assert_allclose(
        Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix(), POSE.rotation,
        atol=1e-12,
    )
    np.testing.assert_array_equal(message.pose.covariance, np.arange(36.0))


def test_twist_is_linear_and_then_angular() -> None:
    """With its own covariance, of any layout."""
    message = body_twist_message(POSE, 'optical')
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    assert (linear.x, linear.y, linear.z) == (0.0, 1.0, 2.0)
    assert (angular.x, angular.y, angular.z) == (3.0, 4.0, 5.0)
    np.testing.assert_array_equal(message.twist.covariance, SQUARE[::-1].ravel())
    assert (message.header.frame_id, message.header.stamp.sec) == ('optical', 1)


@pytest.mark.parametrize('axis', ['x', 'y', 'z'])
@pytest.mark.parametrize('angle', [0.0, 1e-9, 1.0, np.pi - 1e-9, np.pi])
def test_a_turn_about_any_axis_is_a_quaternion(axis: str, angle: float) -> None:
    """Half a turn, too, where the usual formula divides by zero."""
    turn = Rotation.from_euler(axis, angle)
    found = quaternion(turn.as_matrix())
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-12)
    assert found[3] >= 0.0
    assert (Rotation.from_quat(found) * turn.inv()).magnitude() < 1e-8

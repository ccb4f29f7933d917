"""Pose of a body to the messages on target/<body>/pose and twist, /tf, and its truth."""

from __future__ import annotations

from typing import TYPE_CHECKING

from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.transform import transform_message
from blob_tracker.transforms import Transform
from geometry_msgs.msg import (
    PoseStamped, PoseWithCovarianceStamped, TransformStamped, TwistWithCovarianceStamped,
)
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # it loads Numba, and the simulator needs no more than the truth
    from blob_tracker.constellation import Pose


def body_pose_message(pose: Pose, frame_id: str) -> PoseWithCovarianceStamped:
    """
    Return target/<body>/pose: where the body is and how it is turned, in the optical frame.

    The covariance is that of `Pose`, and of ROS alike: m and rad, of the place and of turns about
    the fixed axes of the frame in the header.
    """
    message = PoseWithCovarianceStamped()
    message.header.stamp = from_ns(pose.stamp_ns)
    message.header.frame_id = frame_id
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    place.x, place.y, place.z = pose.position.tolist()
    turn.x, turn.y, turn.z, turn.w = quaternion(pose.rotation)
    message.pose.covariance = pose.covariance.ravel().tolist()
    return message


def body_twist_message(pose: Pose, frame_id: str) -> TwistWithCovarianceStamped:
    """Return target/<body>/twist: m/s and rad/s along and about the axes of the optical frame."""
    message = TwistWithCovarianceStamped()
    message.header.stamp = from_ns(pose.stamp_ns)
    message.header.frame_id = frame_id
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = pose.twist.tolist()
    message.twist.covariance = pose.twist_covariance.ravel().tolist()
    return message


def body_transform_message(pose: Pose, frame_id: str, body: str) -> TransformStamped:
    """Return the same for /tf: how the frame of the body lies in the optical one."""
    x, y, z = pose.position.tolist()
    transform = Transform((x, y, z), quaternion(pose.rotation))
    return transform_message(transform, body, frame_id, pose.stamp_ns)


def true_pose_message(
    rotation: NDArray[np.float64], position: NDArray[np.float64], stamp_ns: int, frame_id: str
) -> PoseStamped:
    """Return simulator/truth/pose: where a body is, m, and how it is turned."""
    message = PoseStamped()
    message.header.stamp = from_ns(stamp_ns)
    message.header.frame_id = frame_id
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = position.tolist()
    turn.x, turn.y, turn.z, turn.w = quaternion(rotation)
    return message


def quaternion(rotation: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """
    Return x, y, z and w >= 0 of the turn of a (3, 3) rotation matrix.

    It is the eigenvector of the greatest eigenvalue of a symmetric matrix (Bar-Itzhack, Journal of
    Guidance, Control, and Dynamics 23 (2000) 1085), which divides by nothing at half a turn.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    _, vectors = np.linalg.eigh(np.array([
        [xx - yy - zz, xy + yx, xz + zx, zy - yz],
        [xy + yx, yy - xx - zz, yz + zy, xz - zx],
        [xz + zx, yz + zy, zz - xx - yy, yx - xy],
        [zy - yz, xz - zx, yx - xy, xx + yy + zz],
    ]))
    x, y, z, w = vectors[:, 3].tolist()
    return (x, y, z, w) if w >= 0.0 else (-x, -y, -z, -w)

"""Position to the messages on target/point and target/pose."""

from __future__ import annotations

from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import ROLL_VARIANCE
from blob_tracker.tracking.triangulation import Position
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped


def point_message(position: Position, frame_id: str) -> PointStamped:
    """Return target/point: m, in the frame of the camera poses."""
    message = PointStamped()
    message.header.stamp = from_ns(position.stamp_ns)
    message.header.frame_id = frame_id
    message.point.x, message.point.y, message.point.z = position.position.tolist()
    return message


def pose_message(position: Position, frame_id: str) -> PoseWithCovarianceStamped:
    """
    Return target/pose: the position with its covariance, m^2.

    How a point of light is turned cannot be seen: the orientation is the identity, and its
    variances are those of angles spread over the circle.
    """
    message = PoseWithCovarianceStamped()
    message.header.stamp = from_ns(position.stamp_ns)
    message.header.frame_id = frame_id
    place = message.pose.pose.position
    place.x, place.y, place.z = position.position.tolist()
    covariance = [0.0] * 36
    for axis, row in enumerate(position.covariance.tolist()):
        covariance[6 * axis:6 * axis + 3] = row
        covariance[6 * (axis + 3) + axis + 3] = ROLL_VARIANCE
    message.pose.covariance = covariance
    return message

"""geometry_msgs/TransformStamped to a transform and back."""

from __future__ import annotations

from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.transforms import Transform
from geometry_msgs.msg import TransformStamped


def to_transform(message: TransformStamped) -> Transform:
    """Return how the child frame lies in the frame of the header, as it stands there."""
    place, turn = message.transform.translation, message.transform.rotation
    return Transform((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w))


def transform_message(
    transform: Transform, frame: str, parent: str, stamp_ns: int
) -> TransformStamped:
    """Return the message of how a frame lies in its parent at an instant, ns."""
    message = TransformStamped(child_frame_id=frame)
    message.header.frame_id = parent
    message.header.stamp = from_ns(stamp_ns)
    place, turn = message.transform.translation, message.transform.rotation
    place.x, place.y, place.z = transform.translation
    turn.x, turn.y, turn.z, turn.w = transform.rotation
    return message

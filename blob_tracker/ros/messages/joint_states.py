"""sensor_msgs/JointState to the angles of a pan/tilt."""

from __future__ import annotations

from blob_tracker.ros.errors import MessageError
from sensor_msgs.msg import JointState


def to_angle(message: JointState, name: str, reverse: bool) -> float | None:
    """
    Return the angle of one joint, rad.

    Parameters
    ----------
    message : JointState
        Of any joints.
    name : str
        Of the joint; empty for one that there is not, whose angle is 0.
    reverse : bool
        Whether it turns to the left, or down, where its angle grows.

    Returns
    -------
    float or None
        None where the message is not of this joint.

    Raises
    ------
    MessageError
        Where the joint has no angle in it.

    """
    if not name:
        return 0.0
    if name not in message.name:
        return None
    index = message.name.index(name)
    if index >= len(message.position):
        raise MessageError(
            f"the joint '{name}' has no position: the message has {len(message.name)} names and "
            f'{len(message.position)} positions; each joint must have one'
        )
    angle = message.position[index]
    return -angle if reverse else angle

"""sensor_msgs/JointState to the angles of a pan/tilt."""

from __future__ import annotations

from collections.abc import Collection

from blob_tracker.ros.errors import MessageError
from sensor_msgs.msg import JointState


def to_angles(message: JointState, names: Collection[str]) -> dict[str, float]:
    """
    Return the angles that a message has of some joints, rad.

    A message may be of one joint, of all of them or of other ones.

    Parameters
    ----------
    message : JointState
        Of any joints.
    names : collection of str
        Of the joints that are asked for.

    Returns
    -------
    dict of str to float
        By the names of those that it has; NaN where a driver has the angle not yet, before homing.

    Raises
    ------
    MessageError
        If one of them has no angle in it, or two.

    """
    angles: dict[str, float] = {}
    for index, name in enumerate(message.name):
        if name not in names:
            continue
        if index >= len(message.position):
            raise MessageError(
                f"the joint '{name:.60}' has no position: the message has {len(message.name)} "
                f'names and {len(message.position)} positions; each joint must have one'
            )
        if name in angles and angles[name] != message.position[index]:
            raise MessageError(
                f"the joint '{name:.60}' stands twice in one message, with different positions"
            )
        angles[name] = message.position[index]
    return angles

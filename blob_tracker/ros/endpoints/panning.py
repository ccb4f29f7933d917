"""Bearings of a light and angles of a pan/tilt of the same time, live."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.ros.endpoints.live_rays import listen
from blob_tracker.ros.endpoints.qos import RESULT, SAMPLES_IN
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.joint_states import to_angles
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState


class JointSeries:
    """
    Collect the angles of joints.

    Parameters
    ----------
    joints : sequence of str
        Their names.

    Attributes
    ----------
    angles : dict of str to dict of int to float
        rad, by the joint, by their stamps, ns.
    names : set of str
        Of all joints that there were.

    """

    def __init__(self, joints: Sequence[str]) -> None:
        self.angles: dict[str, dict[int, float]] = {joint: {} for joint in joints}
        self.names: set[str] = set()

    def take(self, message: JointState) -> None:
        """
        Take a message.

        Raises
        ------
        MessageError
            Where one of the joints has no angle in it, or two.

        """
        self.names.update(message.name)
        for joint, angle in to_angles(message, self.angles).items():
            if math.isfinite(angle):
                self.angles[joint][to_ns(message.header.stamp)] = angle


def live_panning(
    ray: str, joint_states: str, joints: Sequence[str], seconds: float
) -> tuple[list[Bearing], JointSeries]:
    """
    Return what comes on these topics in so many seconds; Ctrl-C stays Python's.

    Raises
    ------
    RecordingError
        Where a name cannot be that of a topic.

    """
    bearings: list[Bearing] = []
    series = JointSeries(joints)

    def take_ray(message: PoseWithCovarianceStamped) -> None:
        try:
            bearings.append(to_bearing(message))
        except MessageError:
            pass  # one that is none is left out

    def take_joints(message: JointState) -> None:
        try:
            series.take(message)
        except MessageError:
            pass

    def subscribe(node: Node) -> None:
        node.create_subscription(PoseWithCovarianceStamped, ray, take_ray, RESULT)
        node.create_subscription(JointState, joint_states, take_joints, SAMPLES_IN)

    listen(subscribe, seconds)
    return bearings, series

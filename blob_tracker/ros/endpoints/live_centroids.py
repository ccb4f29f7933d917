"""Means of target/centroid as it comes, for a command that runs beside the nodes."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
import time

from blob_tracker.ros.diagnostics.connections import why_silent
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.joint_states import to_angles
from blob_tracker.ros.process import shut_down
from geometry_msgs.msg import PointStamped
import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

PATIENCE_S = 10.0  # s without a message: what published it is not there
LISTEN_S = 0.1  # s after which Ctrl-C is looked for
SETTLE_S = 0.3  # s of messages that are thrown away: they were seen before the camera stood still


class NoCentroidsError(RuntimeError):
    """A topic on which nothing usable comes; the message says what to look at."""


class LiveCentroids:
    """
    Listen to the centroids, and to the servo's own angles where their names are given.

    Use it in a with block; Ctrl-C stays Python's.

    Parameters
    ----------
    topic : str
        geometry_msgs/PointStamped, px.
    joints : sequence of str
        Names of the servo's joints; empty if nobody publishes them.
    joint_topic : str
        sensor_msgs/JointState, rad.

    Raises
    ------
    NoCentroidsError
        If a name is not valid for a topic.

    """

    def __init__(
        self, topic: str, joints: Sequence[str] = (), joint_topic: str = 'joint_states'
    ) -> None:
        self._topic, self._joint_topic, self._joints = topic, joint_topic, tuple(joints)
        self._centroids: list[tuple[float, float]] = []
        self._angles: list[tuple[float, ...]] = []
        self._newest: dict[str, float] = {}
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node('calibrate')
        try:
            self._node.create_subscription(PointStamped, topic, self._take_centroid, RESULT)
            if self._joints:
                self._node.create_subscription(
                    JointState, joint_topic, self._take_joints, qos_profile_sensor_data
                )
        except InvalidTopicNameException as error:
            self.close()
            raise NoCentroidsError(str(error)) from None

    def __enter__(self) -> LiveCentroids:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave ROS."""
        self._node.destroy_node()
        shut_down()

    def mean(
        self, count: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """
        Average the next centroids.

        Parameters
        ----------
        count : int
            How many, 2 or more.

        Returns
        -------
        mean, sigma : (2,) arrays
            x, y, px, and the standard deviations of the means, by the scatter of the centroids.
        angles : (j,) array
            Means of the joints' angles over the same time, rad.

        Raises
        ------
        NoCentroidsError
            If nothing comes for 10 s.

        """
        settled = time.monotonic() + SETTLE_S
        while time.monotonic() < settled:
            rclpy.spin_once(self._node, timeout_sec=LISTEN_S)
        self._centroids.clear()
        self._angles.clear()
        self._newest.clear()
        came, since = 0, time.monotonic()
        while len(self._centroids) < count or len(self._angles) < bool(self._joints):
            rclpy.spin_once(self._node, timeout_sec=LISTEN_S)
            if came < len(self._centroids) <= count:  # more of them do not bring the joints
                came, since = len(self._centroids), time.monotonic()
            if time.monotonic() - since > PATIENCE_S:
                raise NoCentroidsError(self._missing(count))
        places = np.array(self._centroids[:count])
        return (
            places.mean(axis=0),
            places.std(axis=0, ddof=1) / np.sqrt(len(places)),
            np.mean(self._angles, axis=0) if self._joints else np.empty(0),
        )

    def _take_centroid(self, message: PointStamped) -> None:
        self._centroids.append((message.point.x, message.point.y))

    def _take_joints(self, message: JointState) -> None:
        try:
            angles = to_angles(message, self._joints)
        except MessageError:  # of velocities alone, say: another one has them
            return
        self._newest |= {name: angle for name, angle in angles.items() if isfinite(angle)}
        if angles and len(self._newest) == len(self._joints):
            self._angles.append(tuple(self._newest[name] for name in self._joints))

    def _missing(self, count: int) -> str:
        """Say what does not come."""
        if reason := why_silent(self._node):
            return reason
        if len(self._centroids) < count:
            return (
                f"no more centroids came on '{self._topic}' within {PATIENCE_S:.0f} s: is the "
                'locator running, and the target in view?'
            )
        return (
            f"no joints {', '.join(self._joints)} came on '{self._joint_topic}' within "
            f'{PATIENCE_S:.0f} s; does the servo publish them under these names?'
        )

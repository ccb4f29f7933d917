"""Bearings of a light and samples of a gyro of the same time, recorded or live."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from blob_tracker.ros.bags import opened, RecordingError
from blob_tracker.ros.endpoints.live_rays import listen
from blob_tracker.ros.endpoints.qos import RESULT, SAMPLES_IN
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.imu import NO_DATA
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import Imu


class Turning(NamedTuple):
    """
    What came while camera and IMU turned.

    Parameters
    ----------
    bearings : dict of int to Bearing
        By their stamps, ns.
    rates : dict of int to (3,) array
        rad/s in the axes of the IMU, by their stamps, ns.
    frame_id : str
        Of the IMU.

    """

    bearings: dict[int, Bearing]
    rates: dict[int, NDArray[np.float64]]
    frame_id: str


class _Taken:
    """Messages as they come."""

    def __init__(self) -> None:
        self.bearings: dict[int, Bearing] = {}
        self.rates: dict[int, NDArray[np.float64]] = {}
        self.frame_id = ''

    def ray(self, message: Any) -> None:
        """Take a ray; one that is none is left out."""
        try:
            bearing = to_bearing(message)
        except MessageError:
            return
        if np.isfinite(bearing.covariance).all():
            self.bearings[bearing.stamp_ns] = bearing

    def imu(self, message: Any) -> None:
        """Take a sample, unless it has no angular velocity."""
        vector = message.angular_velocity
        rate = np.array([vector.x, vector.y, vector.z])
        if message.angular_velocity_covariance[0] != NO_DATA and np.isfinite(rate).all():
            self.rates[to_ns(message.header.stamp)] = rate
            self.frame_id = message.header.frame_id

    def result(self) -> Turning:
        """Return what came."""
        return Turning(self.bearings, self.rates, self.frame_id)


def recorded_turning(bag: Path, ray: str, imu: str) -> Turning:
    """
    Return what a bag has of these topics.

    Raises
    ------
    RecordingError
        If it cannot be read, or lacks one of them.

    """
    taken = _Taken()
    with opened(bag) as recording:
        wanted = {}
        for name, kind, take in (
            (ray, 'geometry_msgs/msg/PoseWithCovarianceStamped', taken.ray),
            (imu, 'sensor_msgs/msg/Imu', taken.imu),
        ):
            topics = [
                each for each in recording.topics
                if each.kind == kind and f'/{each.name}'.endswith(f'/{name.lstrip("/")}')
            ]
            if len(topics) != 1:
                names = ', '.join(sorted(each.name for each in recording.topics))
                raise RecordingError(
                    f'{bag} has {len(topics)} topics {name} of the type {kind}; it has {names}'
                )
            wanted[topics[0]] = take
        for message in recording.messages(list(wanted)):
            wanted[message.topic](recording.decoded(message))
    return taken.result()


def live_turning(ray: str, imu: str, seconds: float) -> Turning:
    """
    Return what comes on these topics in so many seconds; Ctrl-C stays Python's.

    Raises
    ------
    RecordingError
        If a name is not valid for a topic.

    """
    taken = _Taken()

    def subscribe(node: Node) -> None:
        node.create_subscription(PoseWithCovarianceStamped, ray, taken.ray, RESULT)
        node.create_subscription(Imu, imu, taken.imu, SAMPLES_IN)

    listen(subscribe, seconds)
    return taken.result()

"""target/ray -> target/bearing_predicted, target/track and target/tracked."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
import sys
from threading import Lock
import time
from typing import Any

from blob_tracker.nodes.interface.tracker import PARAMETERS
from blob_tracker.ros.clock_jumps import on_clock_jump
from blob_tracker.ros.connections import Connections
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.health import ERROR, Health, WARN
from blob_tracker.ros.imu import to_rate, turn_of
from blob_tracker.ros.joint_states import to_angles
from blob_tracker.ros.light_track import LightTrack
from blob_tracker.ros.names import lights_from_text, target_topic
from blob_tracker.ros.parameters import declare, on_change
from blob_tracker.ros.process import run, say
from blob_tracker.ros.qos import RESULT, SAMPLES_IN, subscription
from blob_tracker.ros.stamp import to_ns
from blob_tracker.ros.target import to_bearing
from blob_tracker.tracking import (
    compile_ahead, PanTiltAngles, PlatformRates, StampJump, Tracker, TrackingError,
)
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import Imu, JointState

CHECK = 0.05  # s between two looks at whether the lights are still tracked
STANDSTILL = 1.0  # s of wall time in which ROS time did not go on: nothing can be predicted
SILENCE = 1.0  # s of wall time without a sample of the platform that is worth a word


class TrackerNode(Node):
    """
    See the module's first line; the work is `blob_tracker.tracking.Tracker`'s.

    Parameters
    ----------
    listen : bool
        Whether bearings come from target/ray; else whoever has them calls `track`.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(self, *, listen: bool = True, elsewhere: Collection[str] = ()) -> None:
        super().__init__('tracker')
        values = declare(self, PARAMETERS, elsewhere)
        self._listen = listen
        self._lock = Lock()  # bearings may come from a thread of the camera's
        self._health = Health(
            self, 'no bearing arrives; is the locator running, and the target in view?'
        )
        self._health.watch(self._report)
        self._connections = Connections(self, self._health)
        self._topics: dict[str, LightTrack] = {}  # of all lights that there ever were
        self._lights: dict[str, LightTrack] = {}
        self._rays: dict[str, Subscription] = {}
        self._inputs: dict[str, Subscription] = {}
        ...

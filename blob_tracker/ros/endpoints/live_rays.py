"""Rays as they come on topics, for so long."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
import time

from blob_tracker.ros.bags import RecordingError
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.process import shut_down
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

LISTEN_S = 0.1  # s after which Ctrl-C is looked for


def live_rays(topics: Mapping[str, str], seconds: float) -> dict[str, list[Bearing]]:
    """
    Return the bearings that come on topics in so many seconds; Ctrl-C stays Python's.

    Parameters
    ----------
    topics : dict of str to str
        Of rays, by the names of their lights.
    seconds : float
        To listen.

    Raises
    ------
    RecordingError
        If a name is not valid for a topic.

    """
    came: dict[str, list[Bearing]] = {light: [] for light in topics}

    def take(light: str, message: PoseWithCovarianceStamped) -> None:
        try:
            came[light].append(to_bearing(message))
        except MessageError:
            pass  # one that is none is left out

    def subscribe(node: Node) -> None:
        for light, topic in topics.items():
            node.create_subscription(
                PoseWithCovarianceStamped, topic, partial(take, light), RESULT)

    listen(subscribe, seconds)
    return came


def listen(subscribe: Callable[[Node], None], seconds: float) -> None:
    """
    Let a node of this process listen for so long.

    Raises
    ------
    RecordingError
        If a name is not valid for a topic.

    """
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('listener')
    try:
        subscribe(node)
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            rclpy.spin_once(node, timeout_sec=LISTEN_S)
    except InvalidTopicNameException as error:
        raise RecordingError(str(error)) from None
    finally:
        node.destroy_node()
        shut_down()

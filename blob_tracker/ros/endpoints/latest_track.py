"""The newest message on target/track, for whoever wants to know where the target goes."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.health import ERROR, Health
from blob_tracker.ros.endpoints.qos import RESULT, subscription
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.track import stamp_offset_of, to_track
from blob_tracker.tracking import Track
from blob_tracker.tracking.extrapolation import extrapolated
from nav_msgs.msg import Odometry
from rclpy.node import Node

FRESH_S = 0.25  # s: after as much a straight line says nothing any more


class LatestTrack:
    """
    Subscribe to target/track and tell where the target is seen at another instant.

    Parameters
    ----------
    node : Node
        Subscribes.
    topic : str
        Name of the topic.
    health : Health
        Hears of messages that are none.

    """

    def __init__(self, node: Node, topic: str, health: Health) -> None:
        self._topic, self._health = topic, health
        self._latest: tuple[Track, int] | None = None  # and what was taken off its stamp, ns
        self._subscription = subscription(node, Odometry, topic, self._take, RESULT)

    def seen_at(self, stamp_ns: int) -> Track | None:
        """Return the track at a camera's stamp, ns; None if the last one is of another time."""
        latest = self._latest  # another thread may take the next one
        if latest is None:
            return None
        track, offset_ns = latest
        here_ns = stamp_ns - offset_ns
        if abs(here_ns - track.stamp_ns) > 1e9 * FRESH_S:
            return None
        return extrapolated(track, here_ns)

    def _take(self, message: Odometry) -> None:
        try:
            self._latest = to_track(message), round(1e9 * stamp_offset_of(message))
        except MessageError as error:
            self._health.fault(ERROR, f'{self._topic}: {error}')

"""What a tracker says of one light: its track, where it will be, and whether that is known."""

from __future__ import annotations

from blob_tracker.ros.endpoints.qos import publisher, RESULT, STATE
from blob_tracker.ros.messages.track import prediction_bytes, track_bytes
from blob_tracker.tracking import Track
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Bool


class TrackTopics:
    """
    Publish where one light goes.

    Parameters
    ----------
    node : Node
        Publishes it.
    topic : str
        What the names begin with: target, or target/<name>.

    """

    def __init__(self, node: Node, topic: str) -> None:
        self._predictions = publisher(node, Vector3Stamped, f'{topic}/bearing_predicted', RESULT)
        self._tracks = publisher(node, Odometry, f'{topic}/track', RESULT)
        self._tracked = publisher(node, Bool, f'{topic}/tracked', STATE)
        self._target = topic.replace('/', '_')
        self._said_tracked: bool | None = None

    def predict(self, track: Track, frame_id: str) -> None:
        """Publish where the light will be, and that it is tracked."""
        self._predictions.publish(prediction_bytes(track, frame_id))
        self._say(True)

    def publish(self, track: Track, frame_id: str, stamp_offset: float) -> None:
        """Publish the track as the camera sees it, and what was taken off its stamps, s."""
        self._tracks.publish(
            track_bytes(track, frame_id, self._target, stamp_offset=stamp_offset)
        )

    def lose(self) -> None:
        """Say that the light is not tracked: nothing is predicted."""
        self._say(False)

    def _say(self, tracked: bool) -> None:
        """Publish on change."""
        if tracked is not self._said_tracked:
            self._tracked.publish(Bool(data=tracked))
            self._said_tracked = tracked

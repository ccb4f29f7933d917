"""What came of each frame as a bag: the topics of the locator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.commands.track.outcome import Outcome
from blob_tracker.ros.endpoints.names import target_topic
from blob_tracker.ros.messages.target import bearing_message, centroid_message, ray_message
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

FRAME_ID = 'camera_optical_frame'


class Bag:
    """
    Write target/bearing, target/centroid and target/ray of each light, as the locator would.

    Without a calibration there is the centroid alone.

    Parameters
    ----------
    path : Path
        The folder to make.

    """

    def __init__(self, path: Path) -> None:
        self._typestore = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Any] = {}
        self._writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()

    def add(self, outcome: Outcome) -> None:
        """Write the messages of an outcome; none if there is no location."""
        if outcome.location is None:
            return
        topic = target_topic(outcome.light)
        if outcome.bearing is not None:
            self._write(f'{topic}/bearing', bearing_message(outcome.bearing, FRAME_ID), outcome)
        self._write(f'{topic}/centroid', centroid_message(outcome.location, FRAME_ID), outcome)
        if outcome.bearing is not None:
            self._write(f'{topic}/ray', ray_message(outcome.bearing, FRAME_ID), outcome)

    def close(self) -> None:
        """End the bag; until then nobody can read it."""
        self._writer.close()

    def _write(self, topic: str, message: Any, outcome: Outcome) -> None:
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                f'/{topic}', f'geometry_msgs/msg/{type(message).__name__}',
                typestore=self._typestore,
            )
        self._writer.write(
            self._connections[topic], outcome.stamp_ns, serialize_message(message)
        )

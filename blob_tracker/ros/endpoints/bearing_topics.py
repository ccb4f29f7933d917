"""What a locator says of one light: its bearing, its centroid and its ray."""

from __future__ import annotations

from blob_tracker.ros.endpoints.qos import publisher, RESULT
from blob_tracker.ros.messages.target import bearing_bytes, centroid_bytes, ray_bytes
from blob_tracker.types import Bearing, Location
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
from rclpy.node import Node


class BearingTopics:
    """
    Publish where one light is.

    Parameters
    ----------
    node : Node
        Publishes it.
    topic : str
        What the names begin with: target, or target/<name>.

    """

    def __init__(self, node: Node, topic: str) -> None:
        self._bearings, self._centroids, self._rays = (
            publisher(node, kind, f'{topic}/{name}', RESULT)
            for kind, name in (
                (Vector3Stamped, 'bearing'),
                (PointStamped, 'centroid'),
                (PoseWithCovarianceStamped, 'ray'),
            )
        )

    def publish(self, bearing: Bearing, location: Location, frame_id: str) -> None:
        """Publish the bearing, which the servo waits for first, and what else is wanted."""
        self._bearings.publish(bearing_bytes(bearing, frame_id))
        if self._centroids.is_wanted:
            self._centroids.publish(centroid_bytes(location, frame_id))
        if self._rays.is_wanted:
            self._rays.publish(ray_bytes(bearing, frame_id))

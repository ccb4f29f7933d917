"""A node that listens to a whole tracker."""

from __future__ import annotations

from collections import deque
import time
from typing import Any

from blob_tracker.ros.endpoints.qos import IMAGE_IN, RESULT
from blob_tracker.ros.messages.camera_info import to_camera_model
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.units import MRAD_PER_RAD
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo

LONGEST = 20_000  # frames that are remembered: ten minutes
RECENT = 60  # bearings over which rates and latencies are taken


class Monitor(Node):
    """
    Collect what the tracker publishes, and the truth where there is one.

    Parameters
    ----------
    namespace : str
        That of its nodes.
    context : Context, optional
        The default one where left out.

    """

    def __init__(self, namespace: str, context: Context | None = None) -> None:
        super().__init__('monitor', namespace=namespace, context=context)
        self.frames: deque[float] = deque(maxlen=2 * RECENT)
        self.latencies: deque[float] = deque(maxlen=LONGEST)
        self.arrivals: deque[float] = deque(maxlen=RECENT)
        self.camera_info = CameraInfo()
        self.bearing: Vector3Stamped | None = None
        self.ray: PoseWithCovarianceStamped | None = None
        self.centroids: dict[int, tuple[float, float]] = {}
        self.covariances: dict[int, NDArray[np.float64]] = {}
        self.truths: dict[int, tuple[float, float]] = {}
        self.states: dict[str, tuple[bytes, str]] = {}
        self.create_subscription(CameraInfo, 'camera/camera_info', self._camera_info, IMAGE_IN)
        for kind, topic, callback in (
            (Vector3Stamped, 'target/bearing', self._bearing),
            (PoseWithCovarianceStamped, 'target/ray', self._ray),
            (PointStamped, 'target/centroid', self._centroid),
            (PointStamped, 'simulator/truth/centroid', self._truth),
            (DiagnosticArray, '/diagnostics', self._diagnostics),
        ):
            self.create_subscription(kind, topic, callback, RESULT)

    def forget(self) -> None:
        """Begin afresh."""
        for store in (self.frames, self.latencies, self.arrivals):
            store.clear()
        for kept in (self.centroids, self.covariances, self.truths):
            kept.clear()

    def pixel_covariance(self, stamp: int) -> NDArray[np.float64]:
        """Return the (2, 2) covariance of a location, px^2, from that of its ray, rad^2."""
        model = to_camera_model(self.camera_info)
        _, _, derivative = model.angles(*self.centroids[stamp])
        inverse = MRAD_PER_RAD * np.linalg.inv(derivative)
        return inverse @ self.covariances[stamp] @ inverse.T

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frames, px."""
        return self.camera_info.width, self.camera_info.height

    def matched_stamps(self) -> list[int]:
        """Return the stamps of the frames that have a location and a truth, in their order."""
        return sorted(stamp for stamp in self.centroids if stamp in self.truths)

    def false_stamps(self) -> list[int]:
        """Return the stamps of locations in frames in which the light was not on."""
        if not self.truths:
            return []
        # Before the first truth and after the last it may still be under way.
        return [s for s in self.centroids if min(self.truths) < s < max(self.truths)
                and s not in self.truths]

    def matched(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the (N, 2) locations and true places of the frames that have both, px."""
        stamps = self.matched_stamps()
        located = np.array([self.centroids[stamp] for stamp in stamps]).reshape(-1, 2)
        return located, np.array([self.truths[stamp] for stamp in stamps]).reshape(-1, 2)

    def _camera_info(self, message: CameraInfo) -> None:
        self.frames.append(time.monotonic())
        self.camera_info = message

    def _bearing(self, message: Vector3Stamped) -> None:
        self.latencies.append(time.time() - to_ns(message.header.stamp) / 1e9)
        self.arrivals.append(time.monotonic())
        self.bearing = message

    def _ray(self, message: PoseWithCovarianceStamped) -> None:
        self.ray = message
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        self._keep(self.covariances, message, covariance[np.ix_([4, 3], [4, 3])])

    def _centroid(self, message: PointStamped) -> None:
        self._keep(self.centroids, message, (message.point.x, message.point.y))

    def _truth(self, message: PointStamped) -> None:
        self._keep(self.truths, message, (message.point.x, message.point.y))

    @staticmethod
    def _keep(store: dict[int, Any], message: Any, value: Any) -> None:
        """Store a value by its stamp; a demo on a real camera may run for days."""
        store[to_ns(message.header.stamp)] = value
        if len(store) > LONGEST:
            del store[next(iter(store))]

    def _diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            name = status.name.split(':')[0]
            if name.startswith(self.get_namespace()):
                self.states[name.rpartition('/')[2]] = (status.level, status.message)

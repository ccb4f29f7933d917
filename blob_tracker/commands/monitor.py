"""A node that listens to a whole tracker."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from functools import partial
import time

from blob_tracker.commands.watched_body import WatchedBody
from blob_tracker.commands.watched_light import RECENT, WatchedLight
from blob_tracker.ros.endpoints.names import target_topic
from blob_tracker.ros.endpoints.qos import IMAGE_IN, RESULT
from blob_tracker.ros.messages.camera_info import to_camera_model
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.units import MRAD_PER_RAD
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import (
    PointStamped, PoseStamped, PoseWithCovarianceStamped, Vector3Stamped,
)
import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo


class Monitor(Node):
    """
    Collect what the tracker publishes, and the truth where there is one.

    Parameters
    ----------
    namespace : str
        That of its nodes.
    context : Context, optional
        The default one if left out.
    lights : sequence of str
        Names of the lights; that of the only one is empty.
    body : str
        Name of the body that carries them; empty if none does.

    """

    def __init__(
        self, namespace: str, context: Context | None = None, lights: Sequence[str] = ('',),
        body: str = '',
    ) -> None:
        super().__init__('monitor', namespace=namespace, context=context)
        self.frames: deque[float] = deque(maxlen=2 * RECENT)
        self.stamps: deque[int] = deque(maxlen=2 * RECENT)
        self.camera_info = CameraInfo()
        self.lights = {name: WatchedLight() for name in lights}
        self.body = WatchedBody(body) if body else None
        self.states: dict[str, tuple[bytes, str]] = {}
        self.create_subscription(CameraInfo, 'camera/camera_info', self._camera_info, IMAGE_IN)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._diagnostics, RESULT)
        for name, light in self.lights.items():
            target = target_topic(name)
            truth = target.replace('target', 'simulator/truth', 1)
            for kind, topic, callback in (
                (Vector3Stamped, f'{target}/bearing', self._bearing),
                (PoseWithCovarianceStamped, f'{target}/ray', self._ray),
                (PointStamped, f'{target}/centroid', self._centroid),
                (PointStamped, f'{truth}/centroid', self._truth),
            ):
                self.create_subscription(kind, topic, partial(callback, light), RESULT)

        if self.body is not None:
            for kind, topic, take in (
                (PoseWithCovarianceStamped, f'{target_topic(body)}/pose', self.body.take),
                (PoseStamped, 'simulator/truth/pose', self.body.take_truth),
            ):
                self.create_subscription(kind, topic, take, RESULT)

    def forget(self) -> None:
        """Restart: know nothing of what came before."""
        self.frames.clear()
        self.stamps.clear()
        for light in self.lights.values():
            light.forget()

    def pixel_covariance(self, light: WatchedLight, stamp: int) -> NDArray[np.float64]:
        """Return the (2, 2) covariance of a location, px^2, from that of its ray, rad^2."""
        model = to_camera_model(self.camera_info)
        _, _, derivative = model.angles(*light.centroids[stamp])
        inverse = MRAD_PER_RAD * np.linalg.inv(derivative)
        return inverse @ light.covariances[stamp] @ inverse.T

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frames, px."""
        return self.camera_info.width, self.camera_info.height

    @property
    def interval_ns(self) -> int:
        """Time from frame to frame, ns; 0 where it is not known yet."""
        return int(np.median(np.diff(self.stamps))) if len(self.stamps) > 1 else 0

    def _camera_info(self, message: CameraInfo) -> None:
        self.frames.append(time.monotonic())
        self.stamps.append(to_ns(message.header.stamp))
        self.camera_info = message

    def _bearing(self, light: WatchedLight, message: Vector3Stamped) -> None:
        light.latencies.append(time.time() - to_ns(message.header.stamp) / 1e9)
        light.arrivals.append(time.monotonic())
        light.bearing = message

    def _ray(self, light: WatchedLight, message: PoseWithCovarianceStamped) -> None:
        light.ray = message
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        light.keep(light.covariances, message, covariance[np.ix_([4, 3], [4, 3])])

    def _centroid(self, light: WatchedLight, message: PointStamped) -> None:
        light.keep(light.centroids, message, (message.point.x, message.point.y))

    def _truth(self, light: WatchedLight, message: PointStamped) -> None:
        light.keep(light.truths, message, (message.point.x, message.point.y))

    def _diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            name = status.name.split(':')[0]
            if name.startswith(self.get_namespace()):
                self.states[name.rpartition('/')[2]] = (status.level, status.message)

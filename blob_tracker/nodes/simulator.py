"""A camera before a simulated flashing light: it publishes what a camera does, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Collection
import sys
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.capture.picture import draw
from blob_tracker.nodes.interface.simulator import PARAMETERS
from blob_tracker.ros.camera_info import from_camera_model
from blob_tracker.ros.connections import Connections
from blob_tracker.ros.debug_image import DebugImage
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.frame_topics import Deliver, FrameTopics
from blob_tracker.ros.health import Health
from blob_tracker.ros.parameters import declare, on_change
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import publisher, RESULT
from blob_tracker.ros.target import bearing_message, centroid_message
from blob_tracker.simulation import flashing_light, PROFILES, Sensor
from blob_tracker.types import Frame, Location, SensorNoise
from geometry_msgs.msg import PointStamped, Vector3Stamped
import numpy as np
from rclpy.node import Node
from rclpy.timer import Timer


class SimulatorNode(Node):
    """
    See the module's first line; the work is that of `blob_tracker.simulation`.

    Parameters
    ----------
    deliver : callable, optional
        Takes each frame in memory, see `FrameTopics`.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(
        self, *, deliver: Deliver | None = None, elsewhere: Collection[str] = ()
    ) -> None:
        super().__init__('simulator')
        values = declare(self, PARAMETERS, elsewhere)
        self._health = Health(
            self,
            'no frame was published',
            'drawing takes longer than a frame; lower rate, width and height, or free the '
            'processor',
        )
        self._connections = Connections(self, self._health)
        self._debug_image = DebugImage(self)
        self._frames = FrameTopics(self, self._health, deliver)
        self._centroids, self._bearings = (
            publisher(self, kind, name, RESULT)
            for kind, name in (
                (PointStamped, 'simulator/truth/centroid'),
                (Vector3Stamped, 'simulator/truth/bearing'),
            )
        )
        self._timer: Timer | None = None
        self._change(values)()
        on_change(self, PARAMETERS, self._change)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build the scene and the camera of these parameters; return what starts them."""
        settings = dict(values)
        frame_id, focal_length = settings.pop('frame_id'), settings.pop('focal_length')
        sensor = Sensor(
            SensorNoise(settings.pop('noise.gain'), settings.pop('noise.read_noise')),
            settings.pop('bits'),
            row_time=settings.pop('row_time'),
        )
        profile = PROFILES[settings.pop('profile')]
        try:
            scene = flashing_light(**settings, profile=profile, sensor=sensor)
        except ValueError as error:
            raise ParameterError(f'{error}; lower row_time, height or rate') from None
        width, height = scene.width, scene.height
        model = CameraModel(width, height, pinhole_matrix(focal_length, width, height))
        try:
            pixels = scene.frame(0)
        except MemoryError:
            raise ParameterError(
                f'there is no room for frames of {width} x {height} px; take smaller ones'
            ) from None

        def use() -> None:
            self._frame_id = frame_id
            self._scene = scene
            self._camera_model = model
            self._info = from_camera_model(model, width, height)
            self._index = 0
            self._pixels = pixels
            if self._timer is not None:
                self.destroy_timer(self._timer)
            self._timer = self.create_timer(1.0 / self._scene.rate, self._publish)

        return use

    def _publish(self) -> None:
        """Publish the frame that is ready, then draw the next: drawing costs no latency."""
        stamp_ns = self.get_clock().now().nanoseconds
        frame = Frame(self._pixels, stamp_ns, self._scene.sensor.saturation)
        self._health.arrived(stamp_ns)
        self._frames.publish(frame, self._info, self._frame_id)
        self._health.left(stamp_ns)
        truth = self._scene.truth(self._index)
        if truth.lit:
            location = Location(
                x=truth.x,
                y=truth.y,
                covariance=np.zeros((2, 2)),
                amplitude=truth.amplitude,
                background=self._scene.background,
                sigma=truth.sigma,
                snr=np.inf,
                chi2=0.0,
                saturated=0,
                stamp_ns=stamp_ns,
            )
            bearing = self._camera_model.bearing(location)
            self._centroids.publish(centroid_message(location, self._frame_id))
            self._bearings.publish(bearing_message(bearing, self._frame_id))
        self._health.count('frames')
        self._health.ok('publishing')
        self._debug_image.offer(
            lambda: draw(frame, [f'{self._health.rate:.2f} Hz of {self._scene.rate:g}']),
            stamp_ns,
            self._frame_id,
        )
        self._index += 1
        self._pixels = self._scene.frame(self._index)


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [SimulatorNode()]))

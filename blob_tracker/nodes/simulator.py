"""A camera before a simulated flashing light: it publishes what a camera does, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Collection
import sys
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.ros.camera_info import from_camera_model
from blob_tracker.ros.connections import Connections
from blob_tracker.ros.frame_topics import Deliver, FrameTopics
from blob_tracker.ros.health import Health
from blob_tracker.ros.parameters import declare, on_change, Parameter
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import publisher, RESULT
from blob_tracker.ros.target import bearing_message, centroid_message
from blob_tracker.simulation import FlashingLight
from blob_tracker.types import Frame, Location, SensorNoise
from geometry_msgs.msg import PointStamped, Vector3Stamped
import numpy as np
from rclpy.node import Node
from rclpy.timer import Timer

_SCENE = FlashingLight()
PARAMETERS = (
    Parameter('width', _SCENE.width, 'Width of the frames.', least=16, most=8192, unit='px'),
    Parameter('height', _SCENE.height, 'Height of the frames.', least=16, most=8192, unit='px'),
    Parameter('rate', _SCENE.rate, 'Frames a second.', least=0.1, most=1000.0, unit='Hz'),
    Parameter(
        'focal_length', 600.0, 'Focal length of the lens.', least=1.0, most=1e6, unit='px'
    ),
    Parameter(
        'sigma',
        _SCENE.sigma,
        "Standard deviation of the light's image.",
        least=0.1,
        most=100.0,
        unit='px',
    ),
    Parameter(
        'amplitude',
        _SCENE.amplitude,
        'Peak of the light above the background.',
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'background',
        _SCENE.background,
        'Mean level of the wall behind it.',
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'texture',
        _SCENE.texture,
        "Standard deviation of the wall's pattern.",
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'noise.gain',
        _SCENE.noise.gain,
        'Electrons per DN of the sensor.',
        least=1e-3,
        most=1e6,
        unit='e-/DN',
    ),
    Parameter(
        'noise.read_noise',
        _SCENE.noise.read_noise,
        'Noise of a dark pixel before quantisation.',
        least=0.0,
        most=1e4,
        unit='DN',
    ),
    Parameter(
        'seed',
        _SCENE.seed,
        'Seed of wall and noise: the same one gives the same pixels.',
        least=0,
        most=2**31 - 1,
    ),
    Parameter('frame_id', 'camera_optical_frame', 'Name of the optical frame.'),
)


class SimulatorNode(Node):
    """
    See the module's first line; the work is `blob_tracker.simulation.FlashingLight`'s.

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
        self._health = Health(self, 'no frame was published')
        self._connections = Connections(self, self._health)
        self._frames = FrameTopics(self, deliver)
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
        scene = dict(values)
        frame_id, focal_length = scene.pop('frame_id'), scene.pop('focal_length')
        noise = SensorNoise(scene.pop('noise.gain'), scene.pop('noise.read_noise'))

        def use() -> None:
            self._frame_id = frame_id
            self._scene = FlashingLight(**scene, noise=noise)
            width, height = self._scene.width, self._scene.height
            self._camera_model = CameraModel(
                width, height, pinhole_matrix(focal_length, width, height)
            )
            self._info = from_camera_model(self._camera_model, width, height)
            self._index = 0
            self._pixels = self._scene.frame(0)
            if self._timer is not None:
                self.destroy_timer(self._timer)
            self._timer = self.create_timer(1.0 / self._scene.rate, self._publish)

        return use

    def _publish(self) -> None:
        """Publish the frame that is ready, then draw the next: drawing costs no latency."""
        stamp_ns = self.get_clock().now().nanoseconds
        frame = Frame(self._pixels, stamp_ns, self._scene.saturation)
        self._frames.publish(frame, self._info, self._frame_id)
        truth = self._scene.truth(self._index)
        if truth.lit:
            location = Location(
                x=truth.x,
                y=truth.y,
                covariance=np.zeros((2, 2)),
                amplitude=self._scene.amplitude,
                background=self._scene.background,
                sigma=self._scene.sigma,
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
        self._index += 1
        self._pixels = self._scene.frame(self._index)


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [SimulatorNode()]))

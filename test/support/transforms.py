"""TF as other people's nodes publish it."""

from __future__ import annotations

from blob_tracker.ros.endpoints.qos import TF, TF_STATIC
from blob_tracker.ros.messages.transform import transform_message
from blob_tracker.transforms import Transform
import numpy as np
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from scipy.spatial.transform import Rotation
from support.processes import Probe

STATIC = QoSProfile(  # of tf2_ros' static broadcasters: the last message is that of all frames
    depth=1, reliability=TF_STATIC.reliability, durability=TF_STATIC.durability
)
OPTICAL = -np.pi / 2, 0.0, -np.pi / 2  # in a frame with x forward, y left, z up (REP 103)


def transform(
    x: float = 0.0, y: float = 0.0, z: float = 0.0,
    roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0,
) -> Transform:
    """Return the transform that static_transform_publisher makes of these numbers."""
    turn = Rotation.from_euler('xyz', [roll, pitch, yaw])
    return Transform((float(x), float(y), float(z)), tuple(turn.as_quat().tolist()))


class Broadcaster:
    """Publish on /tf and /tf_static."""

    def __init__(self, node: Probe) -> None:
        from tf2_msgs.msg import TFMessage

        self._kind = TFMessage
        self.moving: Publisher = node.create_publisher(TFMessage, '/tf', TF)
        self.static: Publisher = node.create_publisher(TFMessage, '/tf_static', STATIC)
        self._static: dict[str, object] = {}

    def hold(self, **frames: tuple[str, Transform]) -> None:
        """Say where frames lie in their parents for good, with all that was said before."""
        for frame, (parent, how) in frames.items():
            self._static[frame] = transform_message(how, frame, parent, 0)
        self.static.publish(self._kind(transforms=list(self._static.values())))

    def move(self, stamp_ns: int, **frames: tuple[str, Transform]) -> None:
        """Say where frames lie in their parents at an instant, ns."""
        self.moving.publish(self._kind(transforms=[
            transform_message(how, frame, parent, stamp_ns)
            for frame, (parent, how) in frames.items()
        ]))

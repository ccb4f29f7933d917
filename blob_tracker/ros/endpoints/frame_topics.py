"""The topics of a camera, each published only while somebody subscribes."""

from __future__ import annotations

import traceback

from blob_tracker.ros.diagnostics.health import ERROR, Health
from blob_tracker.ros.endpoints.delivery import Deliver, Delivery
from blob_tracker.ros.endpoints.qos import IMAGE_OUT, publisher
from blob_tracker.ros.messages.camera_info import stamped
from blob_tracker.ros.messages.image import from_frame
from blob_tracker.types import Frame
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image


class FrameTopics:
    """
    Publish frames with their camera_info, and hand them over in memory.

    Parameters
    ----------
    node : Node
        Publishes them.
    health : Health
        Hears of a deliver that fails.
    deliver : callable, optional
        Takes each frame before it is published: who is in the same process does not wait for who
        is not.

    """

    def __init__(
        self,
        node: Node,
        health: Health,
        deliver: Deliver[tuple[Frame, CameraInfo]] | None = None,
    ) -> None:
        self._node = node
        self._health = health
        self._deliver = deliver
        self._image = Image()
        self._images, self._infos = (
            publisher(node, kind, name, IMAGE_OUT)
            for kind, name in ((Image, 'camera/image_raw'), (CameraInfo, 'camera/camera_info'))
        )

    def publish(self, frame: Frame, info: CameraInfo, frame_id: str) -> None:
        """
        Give a frame to all who want it.

        The camera_info goes first: it is small, and who pairs the two (`FramePairs`) has it by
        the time the pixels are there.
        """
        if self._deliver is not None:
            try:
                self._deliver(Delivery((frame, info), frame_id))
            except Exception as error:  # a fault of theirs is none of the camera's
                if not rclpy.ok():  # a signal came: nothing can be published any more
                    raise
                self._node.get_logger().error(traceback.format_exc(), throttle_duration_sec=60.0)
                self._health.fault(
                    ERROR,
                    f'segmenter or locator failed with {type(error).__name__}: {error}; please '
                    'report it with the log',
                )
        if self._infos.is_wanted:
            self._infos.publish(stamped(info, frame.stamp_ns, frame_id))
        if self._images.is_wanted:
            self._images.publish(from_frame(frame, frame_id, self._image))

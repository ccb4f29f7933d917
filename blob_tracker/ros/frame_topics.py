"""The topics of a camera, each published only while somebody subscribes."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.ros.camera_info import stamped
from blob_tracker.ros.image import from_pixels
from blob_tracker.ros.qos import IMAGE_OUT, publisher
from blob_tracker.types import Frame
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

Deliver = Callable[[Frame, CameraInfo, str], None]


class FrameTopics:
    """
    Publish frames with their camera_info, and hand them over in memory.

    Parameters
    ----------
    node : Node
        Publishes them.
    deliver : callable, optional
        Takes each frame, its camera_info and the name of the optical frame before they are
        published: who is in the same process does not wait for who is not. The camera_info is
        filled again for the next frame.

    """

    def __init__(self, node: Node, deliver: Deliver | None = None) -> None:
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
        stamped(info, frame.stamp_ns, frame_id)
        if self._deliver is not None:
            self._deliver(frame, info, frame_id)
        if self._infos.get_subscription_count():
            self._infos.publish(info)
        if self._images.get_subscription_count():
            self._images.publish(from_pixels(frame.image, frame.stamp_ns, frame_id, self._image))

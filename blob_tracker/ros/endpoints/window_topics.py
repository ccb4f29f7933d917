"""What a segmenter says of one light: its windows, and whether it is in view."""

from __future__ import annotations

from blob_tracker.ros.endpoints.qos import IMAGE_OUT, publisher, STATE
from blob_tracker.ros.messages.camera_info import WindowInfos
from blob_tracker.ros.messages.image import window_bytes
from blob_tracker.types import Window
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool


class WindowTopics:
    """
    Publish what a segmenter has to say of one light.

    Parameters
    ----------
    node : Node
        Publishes it.
    topic : str
        What the names begin with: target, or target/<name>.

    Attributes
    ----------
    lost_after_ns : int
        Time without the light, by the stamps, after which it is no longer visible.

    """

    def __init__(self, node: Node, topic: str) -> None:
        self.lost_after_ns = 0
        self._windows, self._infos, self._visible = (
            publisher(node, kind, f'{topic}/{name}', qos)
            for kind, name, qos in (
                (Image, 'window/image_raw', IMAGE_OUT),
                (CameraInfo, 'window/camera_info', IMAGE_OUT),
                (Bool, 'visible', STATE),
            )
        )
        self._serialiser = WindowInfos()
        self._seen_ns: int | None = None
        self._said_visible: bool | None = None

    def publish(self, window: Window, frame_id: str, info: CameraInfo) -> None:
        """Publish the window while somebody subscribes, the camera_info first, as a frame's."""
        if self._infos.is_wanted:
            self._infos.publish(self._serialiser.serialised(info, window, frame_id))
        if self._windows.is_wanted:
            self._windows.publish(window_bytes(window, frame_id))

    def visible(self, stamp_ns: int, seen: bool) -> bool:
        """Tell whether the light is in view at a frame's stamp, and publish it on change."""
        if seen:
            self._seen_ns = stamp_ns
        visible = self._seen_ns is not None and 0 <= (
            stamp_ns - self._seen_ns
        ) <= self.lost_after_ns
        self._say(visible)
        return visible

    def forget(self) -> None:
        """Forget when the light was seen: what follows is of another time."""
        self._seen_ns = None

    def out_of_view(self) -> None:
        """Say that the light is out of view: no frame comes that could show it."""
        self._say(False)

    def _say(self, visible: bool) -> None:
        """Publish on change."""
        if visible is not self._said_visible:
            self._visible.publish(Bool(data=visible))
            self._said_visible = visible

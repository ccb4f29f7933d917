"""The messages of a window, as a segmenter sends their bytes."""

from __future__ import annotations

from blob_tracker.ros.messages.camera_info import WindowInfos
from blob_tracker.ros.messages.image import window_bytes
from blob_tracker.types import Window
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CameraInfo, Image


def from_window(window: Window, frame_id: str) -> Image:
    """Return the message of `window_bytes`."""
    message: Image = deserialize_message(window_bytes(window, frame_id), Image)
    return message


def of_window(info: CameraInfo, window: Window, frame_id: str) -> CameraInfo:
    """Return the message of `WindowInfos`."""
    content = WindowInfos().serialised(info, window, frame_id)
    message: CameraInfo = deserialize_message(content, CameraInfo)
    return message

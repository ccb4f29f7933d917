"""The link between two nodes of one process: an object in memory in place of its messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from blob_tracker.types import Bearing, filled_at_once, Frame, Window
from sensor_msgs.msg import CameraInfo

Item = TypeVar('Item', tuple[Frame, CameraInfo], tuple[Window, CameraInfo], Bearing)


@filled_at_once
@dataclass(frozen=True)
class Delivery(Generic[Item]):
    """
    What one node hands to the next, from a message or in place of it.

    Parameters
    ----------
    item : (Frame, CameraInfo), (Window, CameraInfo) or Bearing
        What the topics carry. The camera_info is that of the frame, also of a window's; the camera
        fills it again for the next frame.
    frame_id : str
        Name of the optical frame.
    light : str
        Name of the light; empty for a frame, and for the light without a name.

    """

    item: Item
    frame_id: str
    light: str = ''


# What takes it: `SegmenterNode.segment`, `LocatorNode.locate`, `TrackerNode.track`.
Deliver = Callable[[Delivery[Item]], None]

"""LightRange to the message on target/range."""

from __future__ import annotations

import math

from blob_tracker.camera.light_range import LightRange
from blob_tracker.ros.messages.stamp import from_ns
from sensor_msgs.msg import Range


def range_message(light_range: LightRange, stamp_ns: int, frame_id: str) -> Range:
    """Return target/range: m along the ray, with its variance; any distance is valid."""
    message = Range()
    message.header.stamp = from_ns(stamp_ns)
    message.header.frame_id = frame_id
    message.radiation_type = Range.INFRARED  # the one of the two that is light
    message.field_of_view = light_range.angle
    message.min_range, message.max_range = 0.0, math.inf
    message.range = light_range.distance
    message.variance = light_range.variance
    return message

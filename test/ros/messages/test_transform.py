"""Transforms to messages and back."""

from __future__ import annotations

from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.transform import to_transform, transform_message
from blob_tracker.transforms import Transform


def test_there_and_back() -> None:
    """To the bit, with the names of both frames."""
    transform = Transform((1.0, -2.0, 0.1), (0.5, -0.5, 0.5, 0.5))
    message = transform_message(transform, 'camera', 'map', 1_700_000_000_123_456_789)
    assert (message.header.frame_id, message.child_frame_id) == ('map', 'camera')
    assert to_ns(message.header.stamp) == 1_700_000_000_123_456_789
    assert to_transform(message) == transform

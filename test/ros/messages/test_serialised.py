"""What we serialise is what rclpy makes of the same message, byte by byte."""

from collections.abc import Callable
from typing import Any

from blob_tracker.ros.messages.serialised import serialised
from blob_tracker.ros.messages.target import bearing_bytes, centroid_bytes, ray_bytes
from blob_tracker.ros.messages.track import prediction_bytes, track_bytes
from blob_tracker.tracking import Track
from blob_tracker.types import Bearing, Location
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message

RANDOM = np.random.default_rng(2)
STAMP_NS = 1_700_000_000_123_456_789
BEARING = Bearing(120.0, -75.0, np.array([[0.04, 0.01], [0.01, 0.09]]), STAMP_NS)
LOCATION = Location(1.5, np.nan, np.eye(2), 1, 1, 1, 1, 1, 0, STAMP_NS)
TRACK = Track(STAMP_NS, RANDOM.normal(size=4), RANDOM.normal(size=(4, 4)))
MESSAGES: list[tuple[type, Callable[[str], bytes]]] = [
    (Vector3Stamped, lambda frame_id: bearing_bytes(BEARING, frame_id)),
    (PointStamped, lambda frame_id: centroid_bytes(LOCATION, frame_id)),
    (PoseWithCovarianceStamped, lambda frame_id: ray_bytes(BEARING, frame_id)),
    (Vector3Stamped, lambda frame_id: prediction_bytes(TRACK, frame_id)),
    (Odometry, lambda frame_id: track_bytes(TRACK, frame_id, frame_id[::-1], stamp_offset=0.5)),
]


@pytest.mark.parametrize('kind, made', MESSAGES)
@pytest.mark.parametrize('frame_id', [*('optical_frame'[:n] for n in range(9)), 'Kamera/für ß'])
def test_bytes_are_those_of_rclpy(kind: type, made: Callable[[str], bytes], frame_id: str) -> None:
    """Of every length of text; what fills a gap before a number is anything in Fast DDS's own."""
    ours = made(frame_id)
    message: Any = deserialize_message(ours, kind)
    assert message.header.frame_id == frame_id
    theirs = serialize_message(message)
    gaps = _gaps([frame_id] if kind is not Odometry else [frame_id, frame_id[::-1]])
    assert len(ours) == len(theirs)
    assert all(a == b or place in gaps for place, (a, b) in enumerate(zip(ours, theirs)))


def _gaps(texts: list[str]) -> set[int]:
    """Return the places at which there is nothing: before a length and before the numbers."""
    place, gaps = 12, set[int]()
    for text in texts:
        gaps |= set(range(place, place + -place % 4))
        place += -place % 4 + 4 + len(text.encode()) + 1
    return gaps | set(range(place, place + -(place - 4) % 8))


def test_a_stamp_before_1970_counts_its_part_of_a_second_upwards() -> None:
    """As any stamp of ROS."""
    message: Any = deserialize_message(serialised(-1, ('',), [0.0, 0.0, 0.0]), Vector3Stamped)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (-1, 999_999_999)

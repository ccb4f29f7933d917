"""What we serialise is what rclpy makes of the same message, byte by byte."""

from array import array
from collections.abc import Callable
from copy import copy
from typing import Any

from blob_tracker.ros.messages.camera_info import WindowInfos
from blob_tracker.ros.messages.image import window_bytes
from blob_tracker.ros.messages.serialised import serialised
from blob_tracker.ros.messages.target import bearing_bytes, centroid_bytes, ray_bytes
from blob_tracker.ros.messages.track import prediction_bytes, track_bytes
from blob_tracker.tracking import Track
from blob_tracker.types import Bearing, Location, Pixels, Window
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, Image, RegionOfInterest
from std_msgs.msg import Header

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


@pytest.mark.parametrize('frame_id', ['', 'optical', 'Kamera/für ß'])
@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
@pytest.mark.parametrize('unlit', [False, True])
def test_a_window_is_that_of_rclpy(frame_id: str, kind: type, unlit: bool) -> None:
    """Filled field by field; also of odd widths."""
    pixels: Pixels = RANDOM.integers(0, 256, (2, 5, 7)).astype(kind)
    window = Window(pixels[0], pixels[1] if unlit else None, stamp_ns=STAMP_NS)
    planes = pixels[:1 + unlit]
    encoding = f'{8 * pixels.itemsize}UC{len(planes)}'
    ours = window_bytes(window, frame_id)
    whole = Image(height=5, width=7, encoding=encoding, step=7 * len(planes) * pixels.itemsize)
    whole.header.stamp.sec, whole.header.stamp.nanosec = divmod(STAMP_NS, 10**9)
    whole.header.frame_id = frame_id
    whole.data = array('B', np.moveaxis(planes, 0, -1).tobytes())
    assert deserialize_message(ours, Image) == whole
    theirs = serialize_message(whole)
    at = 16 + len(frame_id.encode()) + 1
    size = at + -at % 4
    flag = size + 12 + len(encoding) + 1
    gaps = {*range(at, size), *range(flag + 1, flag + 1 + -(flag + 1) % 4)}
    assert len(ours) == len(theirs)
    assert all(a == b or place in gaps for place, (a, b) in enumerate(zip(ours, theirs)))


@pytest.mark.parametrize('frame_id', ['', 'optical', 'Kamera/für ß'])
def test_the_camera_info_of_a_window_is_that_of_rclpy(frame_id: str) -> None:
    """Whatever it was asked for before."""
    infos = WindowInfos()
    for count in (4, 5, 0, 5, 5):
        info = CameraInfo(width=640, height=480, distortion_model='plumb_bob' * (count > 0))
        info.d, info.k = RANDOM.normal(size=count), RANDOM.normal(size=9)
        info.binning_x = info.binning_y = 2
        for place in (3, 4):
            window = Window(
                np.zeros((5, 7), np.uint8), x0=place, y0=9, stamp_ns=STAMP_NS, binning=(2, 2)
            )
            whole = copy(info)
            whole.roi = RegionOfInterest(x_offset=place, y_offset=9, width=14, height=10)
            whole.header = Header(frame_id=frame_id)
            whole.header.stamp.sec, whole.header.stamp.nanosec = divmod(STAMP_NS, 10**9)
            ours = infos.serialised(info, window, frame_id)
            assert deserialize_message(ours, CameraInfo) == whole
            assert len(ours) == len(serialize_message(whole))


def test_a_stamp_before_1970_counts_its_part_of_a_second_upwards() -> None:
    """As any stamp of ROS."""
    message: Any = deserialize_message(serialised(-1, ('',), [0.0, 0.0, 0.0]), Vector3Stamped)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (-1, 999_999_999)

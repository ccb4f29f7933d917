"""Frames of bags: each image with the camera_info of its stamp, whichever comes first."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.ros.bags import opened
from blob_tracker.ros.endpoints.recording import recorded_frames, recorded_info
from blob_tracker.ros.messages.camera_info import to_camera_model
import numpy as np
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import get_typestore, Stores

TOPIC = 'front/image_raw'
SECOND_NS = 10**9
STORE = get_typestore(Stores.ROS1_NOETIC)


def write(path: Path, order: str, late_ns: int = 0) -> Path:
    """Write images (i) and camera_infos (c), so late, of the stamps 1, 2, 3 ... s in an order."""
    types = STORE.types
    of_kind: dict[str, Any] = {}
    seen = {'i': 0, 'c': 0}
    region = types['sensor_msgs/msg/RegionOfInterest'](2, 4, 2, 6, False)
    with Writer(path) as writer:
        for kind, topic, name in (
            ('i', TOPIC, 'sensor_msgs/msg/Image'),
            ('c', 'front/camera_info', 'sensor_msgs/msg/CameraInfo'),
        ):
            of_kind[kind] = writer.add_connection(f'/{topic}', name, typestore=STORE)
        for index, kind in enumerate(order):
            seen[kind] += 1
            instant_ns = seen[kind] * SECOND_NS + late_ns * (kind == 'c')
            stamp = types['builtin_interfaces/msg/Time'](*divmod(instant_ns, SECOND_NS))
            header = types['std_msgs/msg/Header'](index, stamp, 'front')
            name = of_kind[kind].msgtype
            if kind == 'i':
                pixels = np.full(12, seen[kind], np.uint8)
                message = types[name](header, 2, 6, 'mono8', 0, 6, pixels)
            else:
                message = types[name](
                    header, 20, 30, 'plumb_bob', np.zeros(5), np.diag([9.0, 9.0, 1.0]).ravel(),
                    np.eye(3).ravel(), np.zeros(12), 1, 1, region,
                )
            writer.write(of_kind[kind], index, STORE.serialize_ros1(message, name))
    return path


@pytest.mark.parametrize(('order', 'stamps'), [
    ('icic', [1, 2]), ('ciic', [1, 2]), ('iicc', [1, 2]), ('iiic', [1]), ('ii', []),
])
def test_an_image_comes_with_its_camera_info(
    tmp_path: Path, order: str, stamps: list[int]
) -> None:
    """In any order; one that has none is left out, and crop and binning are its own."""
    bag = write(tmp_path / 'r.bag', order)
    found = list(recorded_frames(bag, TOPIC, paired=True))
    assert [frame.stamp_ns for frame, _ in found] == [each * SECOND_NS for each in stamps]
    for frame, info in found:
        assert (frame.x0, frame.y0, frame.image[0, 0]) == (2, 4, frame.stamp_ns // SECOND_NS)
        assert to_camera_model(info).matrix[0, 0] == 9.0


@pytest.mark.parametrize('late_ms', [0.12, -0.12, 400.0])
@pytest.mark.parametrize('order', ['icicicic', 'cicicici', 'iciiccic', 'iiiccicc', 'cccciiii'])
def test_the_nearest_stamp_will_do(tmp_path: Path, order: str, late_ms: float) -> None:
    """Within half an interval of the images, as in the nodes; by how much is told once."""
    bag = write(tmp_path / 'r.bag', order, round(1e6 * late_ms))
    told: list[str] = []
    found = list(recorded_frames(bag, TOPIC, paired=True, warn=told.append))
    pairs = sorted((frame.stamp_ns // SECOND_NS, info.header.stamp) for frame, info in found)
    assert [stamp for stamp, _ in pairs] == [1, 2, 3, 4]
    for stamp, info in pairs:
        assert info.sec + 1e-9 * info.nanosec == pytest.approx(stamp + 1e-3 * late_ms)
    side = 'after' if late_ms > 0.0 else 'before'
    assert told == [
        f'{bag}: camera_info has stamps {abs(late_ms):.3f} ms {side} those of the images; each '
        'image goes with the nearest'
    ]


def test_beyond_half_an_interval_there_is_none(tmp_path: Path) -> None:
    """The images are counted."""
    bag = write(tmp_path / 'r.bag', 'iiicccic', 10 * SECOND_NS)
    told: list[str] = []
    assert not list(recorded_frames(bag, TOPIC, paired=True, warn=told.append))
    assert told == [f'{bag}: 4 images have no camera_info of their stamp and are left out']


def test_without_the_camera_info_they_are_whole_pictures(tmp_path: Path) -> None:
    """All of them; and there is none to be found."""
    bag = write(tmp_path / 'r.bag', 'iii')
    found = list(recorded_frames(bag, TOPIC, paired=False))
    assert len(found) == 3 and all(info is None for _, info in found)
    assert (found[0][0].x0, found[0][0].image.shape) == (0, (2, 6))
    with opened(bag) as recording:
        assert recorded_info(recording, TOPIC) is None
    with opened(write(tmp_path / 's.bag', 'ic')) as recording:
        assert recorded_info(recording, TOPIC).width == 30

"""Bags as a source of frames."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.commands.sources import grey_frames
from blob_tracker.commands.sources.bag import open_bag
import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore, Stores

PIXELS = np.arange(6, dtype=np.uint8)


def test_fields_are_woven_where_it_is_asked_for(tmp_path: Path) -> None:
    """By the camera_info beside the images; one that is missing leaves a field as it is."""
    bag = tmp_path / 'fields'
    types = get_typestore(Stores.ROS2_JAZZY)
    names = {each.rpartition('/')[2]: kind for each, kind in types.types.items()}
    with Writer(bag, version=8) as writer:
        infos, images = (
            writer.add_connection(f'front/{name}', f'sensor_msgs/msg/{kind}', typestore=types)
            for name, kind in (('camera_info', 'CameraInfo'), ('image_raw', 'Image')))
        for index in range(5):
            header = names['Header'](names['Time'](1, 20_000_000 * index), 'optical')
            image = names['Image'](header, 3, 2, 'mono8', 0, 2, PIXELS + index)
            roi = names['RegionOfInterest'](0, index % 2, 6, 2, False)
            info = names['CameraInfo'](
                header, 8, 2, 'plumb_bob', np.zeros(5), np.zeros(9), np.zeros(9), np.zeros(12),
                1, 2, roi)
            for connection, message in ((infos, info), (images, image)):
                data = types.serialize_cdr(message, connection.msgtype)
                writer.write(connection, 10**9 + 20_000_000 * index, data)
    fields, pictures = (
        list(grey_frames(open_bag(bag, 'front/image_raw', calibrated=False, woven=woven)))
        for woven in (False, True)
    )
    assert len(fields) == 5
    assert [seconds for _, seconds, _ in pictures] == pytest.approx([0.0, 0.04])
    assert pictures[0][2].tolist() == [
        [0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [4, 5], [5, 6]]

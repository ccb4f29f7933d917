"""Bags of older distributions are read; what is no bag of ROS 2 is refused with a sentence."""

from __future__ import annotations

from pathlib import Path
import sqlite3

from blob_tracker.ros.bags import opened, RecordingError
import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore, Stores
from support.bags import recorded_pixels

PIXELS = np.arange(6, dtype=np.uint8)


def test_a_bag_that_does_not_tell_its_types_is_read(tmp_path: Path) -> None:
    """Those of distributions before Jazzy."""
    bag = tmp_path / 'old'
    types = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(bag, version=8) as writer:
        connection = writer.add_connection('camera', 'sensor_msgs/msg/Image', typestore=types)
        image = types.types['sensor_msgs/msg/Image']
        header = types.types['std_msgs/msg/Header']
        time = types.types['builtin_interfaces/msg/Time']
        message = image(header(time(1, 0), 'optical'), 2, 3, 'mono8', 0, 3, PIXELS)
        data = types.serialize_cdr(message, connection.msgtype)
        writer.write(connection, 10**9, data)
    (file,) = bag.glob('*.db3')
    with sqlite3.connect(file) as database:
        database.execute('DELETE FROM message_definitions')
    ((_, pixels),) = recorded_pixels(bag, '/camera')
    assert (pixels == PIXELS.reshape(2, 3)).all()


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    """Neither nothing nor a folder of something else."""
    for bag, sentence in (
        (tmp_path / 'none', 'there is no bag'), (tmp_path, 'not a bag that can be read')
    ):
        with pytest.raises(RecordingError, match=sentence), opened(bag):
            pass

"""Bags of older distributions are read; what is no bag of ROS 2 is refused with a sentence."""

from __future__ import annotations

from pathlib import Path
import sqlite3

from blob_tracker.ros.endpoints.recording import opened, recorded_images, RecordingError
import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore, Stores

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
    ((_, pixels),) = recorded_images(bag, '/camera')
    assert (pixels == PIXELS.reshape(2, 3)).all()


def test_a_bag_of_ros_1_is_to_be_converted(tmp_path: Path) -> None:
    """With the command that does it."""
    bag = tmp_path / 'flight.bag'
    bag.write_bytes(b'#ROSBAG V2.0\n')
    with (
        pytest.raises(RecordingError, match='bag of ROS 1; convert it: rosbags-convert --src'),
        opened(bag),
    ):
        pass


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    """Neither nothing nor a folder of something else."""
    for bag, sentence in (
        (tmp_path / 'none', 'there is no bag'), (tmp_path, 'not a bag that can be read')
    ):
        with pytest.raises(RecordingError, match=sentence), opened(bag):
            pass


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
    assert len(list(recorded_images(bag, 'front/image_raw'))) == 5
    pictures = list(recorded_images(bag, 'front/image_raw', woven=True))
    assert [seconds for seconds, _ in pictures] == pytest.approx([0.02, 0.06])
    assert pictures[0][1].tolist() == [
        [0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [4, 5], [5, 6]]

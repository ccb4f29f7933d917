"""
Write the test bags: one recording of the simulated camera with its truth, in both storages.

    python test/bags/generate.py

Small frames keep the bags below 1 MB each: pixels with noise do not compress. A dropped unlit
frame is part of the recording, as on a real bus.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import shutil
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.ros.messages.target import bearing_message, centroid_message
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Location
import numpy as np
from rclpy.serialization import serialize_message
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

HERE = Path(__file__).parent
BAGS = {'flash_mcap': StoragePlugin.MCAP, 'flash_sqlite3': StoragePlugin.SQLITE3}
FRAMES = 60
DROPPED = 31  # an unlit frame
START_NS = 1_700_000_000_000_000_000
FRAME_ID = 'camera_optical_frame'
TYPES = {
    'camera/image_raw': 'sensor_msgs/msg/Image',
    'camera/camera_info': 'sensor_msgs/msg/CameraInfo',
    'simulator/truth/centroid': 'geometry_msgs/msg/PointStamped',
    'simulator/truth/bearing': 'geometry_msgs/msg/Vector3Stamped',
}


def messages() -> Iterator[tuple[str, int, Any]]:
    """Yield topic, stamp and ROS message in the order of the stamps."""
    scene = flashing_light(width=112, height=88, rate=30.0, sigma=1.6, seed=7, period=5.0)
    model = CameraModel(112, 88, pinhole_matrix(150.0, 112, 88))
    for index in range(FRAMES):
        if index == DROPPED:
            continue
        stamp_ns = START_NS + round(index * 1e9 / scene.rate)
        yield 'camera/image_raw', stamp_ns, from_pixels(scene.frame(index), stamp_ns, FRAME_ID)
        info = from_camera_model(model, scene.width, scene.height)
        yield 'camera/camera_info', stamp_ns, stamped(info, stamp_ns, FRAME_ID)
        truth = scene.truth(index)
        if truth.lit:
            location = Location(
                truth.x, truth.y, np.zeros((2, 2)), truth.amplitude, 0.0, truth.sigma, 0.0, 0.0, 0,
                stamp_ns,
            )
            yield 'simulator/truth/centroid', stamp_ns, centroid_message(location, FRAME_ID)
            bearing = bearing_message(model.bearing(location), FRAME_ID)
            yield 'simulator/truth/bearing', stamp_ns, bearing


def write(path: Path, storage: StoragePlugin) -> None:
    """Write the recording as one bag."""
    no_time = QosTime(0, 0)
    qos = Qos(
        QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, QosDurability.VOLATILE,
        no_time, no_time, QosLiveliness.AUTOMATIC, no_time, False,
    )
    typestore = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=storage) as writer:
        connections = {
            topic: writer.add_connection(
                f'/{topic}', kind, typestore=typestore, offered_qos_profiles=[qos]
            )
            for topic, kind in TYPES.items()
        }
        for topic, stamp_ns, message in messages():
            writer.write(connections[topic], stamp_ns, serialize_message(message))


def main() -> None:
    """Write both bags afresh."""
    for name, storage in BAGS.items():
        shutil.rmtree(HERE / name, ignore_errors=True)
        write(HERE / name, storage)


if __name__ == '__main__':
    main()

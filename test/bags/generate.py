"""
Write the test bags: a light in step, in both storages, and two that carry codes, with their truth.

    python test/bags/generate.py

Small frames keep the bags below 1 MB each: pixels with noise do not compress. A dropped unlit
frame is part of the recording of the light in step, as on a real bus. The coded lights run free,
on clocks that are off by 2 in a thousand, and move by up to 1.8 px a frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
import shutil
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.ros.messages.target import bearing_message, centroid_message
from blob_tracker.simulation import (
    flashing_light, Light, Scene, Truth, truth_of, waveforms_of,
)
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
FRAMES = 60
DROPPED = 31  # an unlit frame
START_NS = 1_700_000_000_000_000_000
FRAME_ID = 'camera_optical_frame'
CODES = {'port': '1101000', 'starboard': '1110100'}
BITS_PER_SECOND = 45.0
CODED_FRAMES = 46
TYPES = {
    'camera/image_raw': 'sensor_msgs/msg/Image',
    'camera/camera_info': 'sensor_msgs/msg/CameraInfo',
    'centroid': 'geometry_msgs/msg/PointStamped',
    'bearing': 'geometry_msgs/msg/Vector3Stamped',
}
Messages = Iterator[tuple[str, int, Any]]  # topic, stamp and message, in the order of the stamps


def in_step() -> Messages:
    """Yield the messages of one light that is on in every other frame."""
    scene = flashing_light(width=112, height=88, rate=30.0, sigma=1.6, seed=7, period=5.0)
    model = CameraModel(112, 88, pinhole_matrix(150.0, 112, 88))
    for index in range(FRAMES):
        if index == DROPPED:
            continue
        stamp_ns = START_NS + round(index * 1e9 / scene.rate)
        yield from _frame(scene, index, model, stamp_ns)
        yield from _truth('simulator/truth', scene.truth(index), model, stamp_ns)


def coded() -> Messages:
    """Yield the messages of two lights that run free and move."""
    waveforms = waveforms_of(
        'coded', codes=CODES, bits_per_second=BITS_PER_SECOND, clock_error=0.002
    )
    lights = {
        name: Light(
            x, 31.5, 1.4, 150.0, waveforms[name], 11.0, 15.4, period=3.0, start=start
        )
        for name, x, start in (('port', 23.0, 0.0), ('starboard', 56.0, 0.3))
    }
    scene = Scene(
        elements=tuple(lights.values()), width=80, height=64, texture=6.0, streaks=True, seed=7
    )
    model = CameraModel(80, 64, pinhole_matrix(150.0, 80, 64))
    for index in range(CODED_FRAMES):
        stamp_ns = START_NS + round(index * 1e9 / scene.rate)
        yield from _frame(scene, index, model, stamp_ns)
        for name, light in lights.items():
            truth = truth_of(light, scene.shot(index))
            yield from _truth(f'simulator/truth/{name}', truth, model, stamp_ns)


def _frame(scene: Scene, index: int, model: CameraModel, stamp_ns: int) -> Messages:
    yield 'camera/image_raw', stamp_ns, from_pixels(scene.frame(index), stamp_ns, FRAME_ID)
    info = from_camera_model(model, scene.width, scene.height)
    yield 'camera/camera_info', stamp_ns, stamped(info, stamp_ns, FRAME_ID)


def _truth(topic: str, truth: Truth, model: CameraModel, stamp_ns: int) -> Messages:
    if truth.amplitude == 0.0:
        return
    location = Location(
        truth.x, truth.y, np.zeros((2, 2)), truth.amplitude, 0.0, truth.sigma, 0.0, 0.0, 0,
        stamp_ns + round(1e9 * truth.tau),
    )
    yield f'{topic}/centroid', stamp_ns, centroid_message(location, FRAME_ID)
    yield f'{topic}/bearing', stamp_ns, bearing_message(model.bearing(location), FRAME_ID)


BAGS: dict[str, tuple[StoragePlugin, Callable[[], Messages]]] = {
    'flash_mcap': (StoragePlugin.MCAP, in_step),
    'flash_sqlite3': (StoragePlugin.SQLITE3, in_step),
    'coded_mcap': (StoragePlugin.MCAP, coded),
}


def write(path: Path, storage: StoragePlugin, messages: Messages) -> None:
    """Write a recording as a bag."""
    no_time = QosTime(0, 0)
    qos = Qos(
        QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, QosDurability.VOLATILE,
        no_time, no_time, QosLiveliness.AUTOMATIC, no_time, False,
    )
    typestore = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=storage) as writer:
        connections: dict[str, Any] = {}
        for topic, stamp_ns, message in messages:
            if topic not in connections:
                kind = TYPES.get(topic) or TYPES[topic.rpartition('/')[2]]
                connections[topic] = writer.add_connection(
                    f'/{topic}', kind, typestore=typestore, offered_qos_profiles=[qos]
                )
            writer.write(connections[topic], stamp_ns, serialize_message(message))


def main() -> None:
    """Write the bags afresh."""
    for name, (storage, messages) in BAGS.items():
        shutil.rmtree(HERE / name, ignore_errors=True)
        write(HERE / name, storage, messages())


if __name__ == '__main__':
    main()

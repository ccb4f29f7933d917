"""Bags of rays, as the locators of a rig publish them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from blob_tracker.ros.messages.target import ray_covariance, turn_onto
from blob_tracker.simulation.waved_light import RigCamera, WavedLight
from blob_tracker.units import MRAD
import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from support.bags import TYPES

KIND = 'geometry_msgs/msg/PoseWithCovarianceStamped'
SIGMA = 1e-4  # rad
START_NS = 1_700_000_000_000_000_000


def serialized(stamp_ns: int, angles: np.ndarray, covariance: np.ndarray) -> bytes:
    """Return a ray as the locator publishes it."""
    azimuth, elevation = (angles / MRAD).tolist()
    types = TYPES.types
    pose = types['geometry_msgs/msg/Pose'](
        types['geometry_msgs/msg/Point'](0.0, 0.0, 0.0),
        types['geometry_msgs/msg/Quaternion'](*turn_onto(azimuth, elevation)))
    stamp = types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9))
    message = types[KIND](
        types['std_msgs/msg/Header'](stamp, 'optical'),
        types['geometry_msgs/msg/PoseWithCovariance'](
            pose, np.array(ray_covariance(covariance / MRAD**2))))
    return bytes(TYPES.serialize_cdr(message, KIND))


def recorded_rays(
    folder: Path, wand: float, lights: Sequence[str], cameras: Mapping[str, RigCamera]
) -> Path:
    """Write a bag of 15 s of the rays of cameras to a waved light; return it."""
    rng = np.random.default_rng(4)
    light = WavedLight(rng, wand)
    messages: list[tuple[int, Any, bytes]] = []
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for name, camera in cameras.items():
            for number, of in enumerate(lights):
                topic = f'/{name}/target/{of + "/" if of else ""}ray'
                connection = writer.add_connection(topic, KIND, typestore=TYPES)
                for time, angles, covariance in zip(*light.seen(camera, number, 15.0, SIGMA, rng)):
                    stamp_ns = START_NS + round(1e9 * time)
                    messages.append((stamp_ns, connection, serialized(
                        stamp_ns, angles, covariance)))
        for stamp_ns, connection, data in sorted(messages, key=lambda each: each[0]):
            writer.write(connection, stamp_ns, data)
    return folder

"""Camera and IMU turned by hand before a light."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.simulation.platform_motion import INTERVAL_S, Ride
from blob_tracker.tracking.rays import directions
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
MOUNTED = Rotation.from_euler('xyz', [-90.0, 0.0, -90.0], degrees=True).inv()  # ROS' axes
SWINGS = ((0.2, 0.31), (0.25, 0.37), (0.3, 0.23))  # rad and Hz, of roll, pitch and yaw by hand
NOISE = 1e-4  # rad/s/sqrt(Hz)
BEARING = 3e-5  # rad


class Drawn(NamedTuple):
    """What `calibrate_imu` takes, and the truth."""

    measured: tuple[Array, Array, Array, Array, Array]
    turn: Rotation
    others: Array


def draw(
    seed: int, axes: tuple[float, float, float] = (1.0, 1.0, 1.0), moves: float = 0.0,
    duration: float = 12.0,
) -> Drawn:
    """Turn by hand before a light, which may move by so many rad/s."""
    random = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(random.normal(scale=0.1, size=3)) * MOUNTED
    offset, bias = random.uniform(-0.05, 0.05), random.normal(scale=5e-3, size=3)
    scale = random.normal(scale=3e-3)
    times = np.arange(0.0, duration + 1.0, INTERVAL_S)
    angles, rates = np.zeros((len(times), 3)), np.zeros((len(times), 3))
    for column, (swing, frequency) in enumerate(SWINGS):
        for part in (1.0, 2.3):
            phase = random.uniform(0.0, 2.0 * np.pi)
            size = axes[column] * swing / part
            speed = 2.0 * np.pi * frequency * part * random.uniform(0.9, 1.1)
            angles[:, column] += size * np.sin(speed * times + phase)
            rates[:, column] += size * speed * np.cos(speed * times + phase)
    ride = Ride(INTERVAL_S, angles, rates)
    ticks = np.arange(0.0, duration, 0.01)
    said = ride.rates(ticks) / (1.0 + scale) @ turn.as_matrix() + bias
    said += NOISE / 0.1 * random.standard_normal(said.shape)
    seen = np.arange(0.1, duration - 0.1, 0.05)
    light = np.stack([moves * seen, np.zeros_like(seen), np.ones_like(seen)], axis=1)
    x, y, z = np.einsum('nij,ni->jn', ride.rotations(seen), light)
    azimuth = np.arctan2(x, z) + BEARING * random.standard_normal(len(seen))
    elevation = np.arctan2(-y, np.hypot(x, z)) + BEARING * random.standard_normal(len(seen))
    covariances = np.tile(BEARING**2 * np.eye(2), (len(seen), 1, 1))
    found = directions(np.stack([azimuth, elevation], axis=1))
    return Drawn(
        (seen, found, covariances, ticks + offset, said), turn,
        np.array([offset, *bias, scale]),
    )

"""Location, Bearing and SensorNoise to the messages on target/..., noise back."""

from __future__ import annotations

from math import cos, pi, sin

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.serialised import serialised
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.types import Bearing, Location, SensorNoise
from blob_tracker.units import MRAD
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message

LEAST_GAIN, MOST_GAIN = 1e-3, 1e6  # electrons per DN: those of no camera lie outside
MOST_READ_NOISE_DN, MOST_BLACK_LEVEL_DN = 1e4, 65535.0  # DN
# The turn about the ray cannot be seen: evenly spread over the circle, rad^2.
ROLL_VARIANCE = pi**2 / 3.0
NOWHERE = 0.0, 0.0, 0.0  # m: a ray begins in the camera


def bearing_bytes(bearing: Bearing, frame_id: str) -> bytes:
    """Return target/bearing, serialised: x azimuth mrad, y elevation mrad, z 0."""
    return serialised(bearing.stamp_ns, (frame_id,), [bearing.azimuth, bearing.elevation, 0.0])


def bearing_message(bearing: Bearing, frame_id: str) -> Vector3Stamped:
    """Return the message of `bearing_bytes`."""
    message: Vector3Stamped = deserialize_message(
        bearing_bytes(bearing, frame_id), Vector3Stamped
    )
    return message


def centroid_bytes(location: Location, frame_id: str) -> bytes:
    """Return target/centroid, serialised: x and y in px of the full sensor, z 0."""
    return serialised(location.stamp_ns, (frame_id,), [location.x, location.y, 0.0])


def centroid_message(location: Location, frame_id: str) -> PointStamped:
    """Return the message of `centroid_bytes`."""
    message: PointStamped = deserialize_message(centroid_bytes(location, frame_id), PointStamped)
    return message


def ray_bytes(bearing: Bearing, frame_id: str) -> bytes:
    """
    Return target/ray, serialised: the turn that takes the optical z axis onto the ray.

    It is a turn by the elevation about x and then by the azimuth about y, q = q_y q_x. The
    covariance, in rad^2, is that of the two angles about x (elevation) and y (azimuth).
    """
    return serialised(bearing.stamp_ns, (frame_id,), [
        *NOWHERE, *turn_onto(bearing.azimuth, bearing.elevation),
        *ray_covariance(bearing.covariance),
    ])


def ray_message(bearing: Bearing, frame_id: str) -> PoseWithCovarianceStamped:
    """Return the message of `ray_bytes`."""
    message: PoseWithCovarianceStamped = deserialize_message(
        ray_bytes(bearing, frame_id), PoseWithCovarianceStamped
    )
    return message


def turn_onto(azimuth: float, elevation: float) -> tuple[float, float, float, float]:
    """Return x, y, z, w of the turn q = q_y q_x that takes the z axis to these angles, mrad."""
    half_azimuth = 0.5 * MRAD * azimuth
    half_elevation = 0.5 * MRAD * elevation
    return (
        cos(half_azimuth) * sin(half_elevation),
        sin(half_azimuth) * cos(half_elevation),
        -sin(half_azimuth) * sin(half_elevation),
        cos(half_azimuth) * cos(half_elevation),
    )


def ray_covariance(of_angles: NDArray[np.float64]) -> list[float]:
    """Return the 36 numbers of a pose for a (2, 2) covariance of azimuth, elevation, mrad^2."""
    covariance = about_x_and_y(of_angles)
    covariance[5 * 6 + 5] = ROLL_VARIANCE
    return covariance


def about_x_and_y(of_angles: NDArray[np.float64]) -> list[float]:
    """Return the same without the roll, as of rates: rad^2 about x (elevation), y (azimuth)."""
    covariance = [0.0] * 36
    (xx, xy), (_, yy) = of_angles.tolist()
    covariance[3 * 6 + 3] = MRAD**2 * yy
    covariance[4 * 6 + 4] = MRAD**2 * xx
    covariance[3 * 6 + 4] = covariance[4 * 6 + 3] = MRAD**2 * xy
    return covariance


def noise_message(noise: SensorNoise, stamp_ns: int, frame_id: str) -> Vector3Stamped:
    """Return target/noise: x gain in electrons per DN, y read noise and z black level in DN."""
    message = Vector3Stamped()
    message.header.stamp = from_ns(stamp_ns)
    message.header.frame_id = frame_id
    message.vector.x = noise.gain
    message.vector.y = noise.read_noise
    message.vector.z = noise.black_level
    return message


def to_noise(message: Vector3Stamped) -> SensorNoise:
    """
    Return the noise of a message on target/noise.

    Raises
    ------
    MessageError
        If a value is none that the parameters noise.gain, noise.read_noise and, but for its
        sign, noise.black_level may have.

    """
    gain, read_noise, black_level = message.vector.x, message.vector.y, message.vector.z
    # NaN is within no bounds.
    if not (
        LEAST_GAIN <= gain <= MOST_GAIN
        and 0.0 <= read_noise <= MOST_READ_NOISE_DN
        and abs(black_level) <= MOST_BLACK_LEVEL_DN
    ):
        raise MessageError(
            f'gain (x) is {gain} electrons per DN, read noise (y) {read_noise} DN and black level '
            f'(z) {black_level} DN; they must be from {LEAST_GAIN:g} to {MOST_GAIN:g}, from 0 to '
            f'{MOST_READ_NOISE_DN:g} and within +-{MOST_BLACK_LEVEL_DN:g}'
        )
    return SensorNoise(gain, read_noise, black_level)

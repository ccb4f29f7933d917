"""Location, Bearing and SensorNoise to the messages on target/..., and noise back."""

from __future__ import annotations

from math import cos, pi, sin

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.stamp import from_ns
from blob_tracker.types import Bearing, Location, SensorNoise
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped

MRAD = 1e-3  # rad
LEAST_GAIN, MOST_GAIN = 1e-3, 1e6  # electrons per DN: those of no camera lie outside
MOST_READ_NOISE, MOST_BLACK_LEVEL = 1e4, 65535.0  # DN
# The turn about the ray cannot be seen: evenly spread over the circle, rad^2.
ROLL_VARIANCE = pi**2 / 3.0


def bearing_message(
    bearing: Bearing, frame_id: str, message: Vector3Stamped | None = None
) -> Vector3Stamped:
    """Return target/bearing: x azimuth mrad, y elevation mrad, z 0; `message` is filled again."""
    message = Vector3Stamped() if message is None else message
    message.header.stamp = from_ns(bearing.stamp_ns)
    message.header.frame_id = frame_id
    message.vector.x = bearing.azimuth
    message.vector.y = bearing.elevation
    return message


def centroid_message(
    location: Location, frame_id: str, message: PointStamped | None = None
) -> PointStamped:
    """Return target/centroid: x and y in px of the full sensor, z 0; `message` is filled again."""
    message = PointStamped() if message is None else message
    message.header.stamp = from_ns(location.stamp_ns)
    message.header.frame_id = frame_id
    message.point.x = location.x
    message.point.y = location.y
    return message


def ray_message(
    bearing: Bearing, frame_id: str, message: PoseWithCovarianceStamped | None = None
) -> PoseWithCovarianceStamped:
    """
    Return target/ray: the turn that takes the optical z axis onto the ray.

    It is a turn by the elevation about x and then by the azimuth about y, q = q_y q_x. The
    covariance, in rad^2, is that of the two angles about x (elevation) and y (azimuth). A
    `message` that is given is filled again.
    """
    message = PoseWithCovarianceStamped() if message is None else message
    message.header.stamp = from_ns(bearing.stamp_ns)
    message.header.frame_id = frame_id
    half_azimuth = 0.5 * MRAD * bearing.azimuth
    half_elevation = 0.5 * MRAD * bearing.elevation
    turn = message.pose.pose.orientation
    turn.x = cos(half_azimuth) * sin(half_elevation)
    turn.y = sin(half_azimuth) * cos(half_elevation)
    turn.z = -sin(half_azimuth) * sin(half_elevation)
    turn.w = cos(half_azimuth) * cos(half_elevation)
    covariance = [0.0] * 36
    in_rad2 = MRAD**2 * bearing.covariance
    covariance[3 * 6 + 3] = float(in_rad2[1, 1])
    covariance[4 * 6 + 4] = float(in_rad2[0, 0])
    covariance[3 * 6 + 4] = covariance[4 * 6 + 3] = float(in_rad2[0, 1])
    covariance[5 * 6 + 5] = ROLL_VARIANCE
    message.pose.covariance = covariance
    return message


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
        Where a value is none that the parameters noise.gain, noise.read_noise and, but for its
        sign, noise.black_level may have.

    """
    gain, read_noise, black_level = message.vector.x, message.vector.y, message.vector.z
    # NaN is within no bounds.
    if not (
        LEAST_GAIN <= gain <= MOST_GAIN
        and 0.0 <= read_noise <= MOST_READ_NOISE
        and abs(black_level) <= MOST_BLACK_LEVEL
    ):
        raise MessageError(
            f'gain (x) is {gain} electrons per DN, read noise (y) {read_noise} DN and black level '
            f'(z) {black_level} DN; they must be from {LEAST_GAIN:g} to {MOST_GAIN:g}, from 0 to '
            f'{MOST_READ_NOISE:g} and within +-{MOST_BLACK_LEVEL:g}'
        )
    return SensorNoise(gain, read_noise, black_level)

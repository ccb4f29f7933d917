"""sensor_msgs/Imu to the rate at which the platform turns."""

from __future__ import annotations

from math import asin, atan2, cos, sin
from typing import TYPE_CHECKING

from blob_tracker.ros.errors import MessageError
import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:  # those of a bag are read where no ROS is installed, too
    from sensor_msgs.msg import Imu

NO_DATA = -1.0  # first element of a covariance, by the message's own convention


def turn_of(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    """
    Return the (3, 3) turn that takes components in the turned frame to those in its parent.

    R_z(yaw) R_y(pitch) R_x(roll), rad, as static_transform_publisher has it (REP 103: fixed
    axes).
    """
    cr, sr, cp, sp, cy, sy = (f(angle) for angle in (roll, pitch, yaw) for f in (cos, sin))
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def angles_of(turn: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the roll, pitch and yaw of which `turn_of` makes a (3, 3) turn, rad."""
    pitch = -asin(min(max(float(turn[2, 0]), -1.0), 1.0))
    roll, yaw = atan2(turn[2, 1], turn[2, 2]), atan2(turn[1, 0], turn[0, 0])
    return roll, pitch, yaw


def to_rate(
    message: Imu, frame_id: str, turn: NDArray[np.float64], bias: ArrayLike = (0.0, 0.0, 0.0)
) -> tuple[NDArray[np.float64], float]:
    """
    Return the rate in the base frame, rad/s, and the variance of each of its components.

    Parameters
    ----------
    message : Imu
        Its angular velocity is used, and nothing else.
    frame_id : str
        The frame that it must be in.
    turn : (3, 3) array
        Takes components in the base frame to those in the frame of the IMU.
    bias : (3,) array
        What the gyro says at rest, in its own axes, rad/s.

    Returns
    -------
    (3,) array, float
        The latter is 0 where the message does not know it, (rad/s)^2.

    Raises
    ------
    MessageError
        If it is of another frame, or has no angular velocity. Whether its numbers can be is
        for `PlatformRates` to say.

    """
    if message.header.frame_id != frame_id:
        raise MessageError(
            f"the frame_id is '{message.header.frame_id:.60}' and imu.frame_id '{frame_id:.60}'; "
            'set imu.frame_id, imu.roll, imu.pitch and imu.yaw to those of the IMU that is to be '
            'used'
        )
    covariance = message.angular_velocity_covariance
    if covariance[0] == NO_DATA:
        raise MessageError(
            'angular_velocity_covariance[0] is -1: this IMU measures no angular velocity; a gyro '
            'is needed, or imu.enabled false'
        )
    vector = message.angular_velocity
    rate = turn.T @ (np.array([vector.x, vector.y, vector.z]) - bias)
    return rate, float(covariance[[0, 4, 8]].max())

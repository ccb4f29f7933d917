"""What a ray of target/ray is: the bearing of its message, read where no ROS is installed, too."""

from __future__ import annotations

from math import atan2, hypot
from typing import TYPE_CHECKING

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # those of a bag are read where no ROS is installed, too
    from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion

UNIT = 1e-3  # that the length of a quaternion may be off 1: more is no rounding


def to_angles(turn: Quaternion) -> tuple[float, float]:
    """
    Return azimuth and elevation, mrad, of the z axis after a turn.

    Raises
    ------
    MessageError
        If the quaternion is not of length 1.

    """
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    square = x * x + y * y + z * z + w * w
    if not abs(square - 1.0) <= 2.0 * UNIT:  # nor NaN
        raise MessageError(
            f'the orientation ({x:g}, {y:g}, {z:g}, {w:g}) is not a rotation; a quaternion must '
            'have length 1'
        )
    right = 2.0 * (x * z + w * y)
    down = 2.0 * (y * z - w * x)
    ahead = square - 2.0 * (x * x + y * y)
    return atan2(right, ahead) / MRAD, atan2(-down, hypot(right, ahead)) / MRAD


def of_another_camera(ray: str, frame_id: str, first: str) -> str:
    """Return what is said of a ray whose frame is not that of the first one."""
    return (
        f'{ray} is in the frame {frame_id!r:.80} and the first was in {first!r:.80}: it is of '
        'another camera, and left out; restart the node if the camera has another name now'
    )


def to_covariance(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (2, 2) covariance of azimuth, elevation, mrad^2, of those of a pose or twist."""
    # x is elevation, y azimuth. Not of NumPy, which warns where a number gets infinite.
    yy, yx, xy, xx = (float(numbers[6 * i + j]) / MRAD**2 for i in (4, 3) for j in (4, 3))
    return np.array([[yy, yx], [xy, xx]])


def to_bearing(message: PoseWithCovarianceStamped) -> Bearing:
    """
    Return the bearing of a message on target/ray, with its covariance as it is.

    Raises
    ------
    MessageError
        If its orientation is no turn. Whether its covariance can be one is the tracker's to
        say, who needs it.

    """
    azimuth, elevation = to_angles(message.pose.pose.orientation)
    return Bearing(
        azimuth,
        elevation,
        to_covariance(message.pose.covariance),
        to_ns(message.header.stamp),
    )

"""The rate of an IMU in the base frame: axes, frames, and what the message itself says."""

from math import pi

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.imu import angles_of, to_rate, turn_of
from geometry_msgs.msg import Vector3
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Imu

BODY = turn_of(-0.5 * pi, 0.0, -0.5 * pi)  # x forward, y left, z up


def imu(x: float, y: float, z: float) -> Imu:
    """Return a message."""
    message = Imu(angular_velocity=Vector3(x=x, y=y, z=z))
    message.header.frame_id = 'imu_link'
    return message


def test_turn_is_that_of_fixed_axes() -> None:
    """Roll, pitch, yaw about x, y, z that do not turn with it (REP 103)."""
    angles = 0.3, -0.7, 1.9
    np.testing.assert_allclose(turn_of(*angles), Rotation.from_euler('xyz', angles).as_matrix())
    np.testing.assert_allclose(turn_of(*angles_of(turn_of(*angles))), turn_of(*angles), atol=1e-12)


@pytest.mark.parametrize('body, base', [
    ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),  # roll: about the optical axis
    ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),  # pitch, nose down: elevation falls
    ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),  # yaw to the left: azimuth falls
])
def test_default_is_a_body_frame(
    body: tuple[float, float, float], base: tuple[float, float, float]
) -> None:
    """The base's axes are right, down, forward."""
    rate, variance = to_rate(imu(*body), 'imu_link', BODY)
    np.testing.assert_allclose(rate, base, atol=1e-15)
    assert variance == 0.0


def test_variance_is_the_largest_of_the_axes() -> None:
    """Zero is unknown, by the message's convention, and is taken as none."""
    message = imu(0.0, 0.0, 0.0)
    message.angular_velocity_covariance[[0, 4, 8]] = 1e-6, 4e-6, 2e-6
    assert to_rate(message, 'imu_link', BODY)[1] == 4e-6


def test_wrong_frame_and_no_gyro_are_refused() -> None:
    """Each by what would be right."""
    with pytest.raises(MessageError, match="'imu_link' and imu.frame_id 'gyro'; set"):
        to_rate(imu(0.0, 0.0, 0.0), 'gyro', BODY)
    message = imu(0.0, 0.0, 0.0)
    message.angular_velocity_covariance[0] = -1.0
    with pytest.raises(MessageError, match='measures no angular velocity'):
        to_rate(message, 'imu_link', BODY)

"""The result messages: units, signs, and a turn that takes z onto the ray."""

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.target import (
    bearing_message,
    centroid_message,
    noise_message,
    ray_message,
    to_noise,
)
from blob_tracker.types import Bearing, Location, SensorNoise
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

BEARING = Bearing(120.0, -75.0, np.array([[0.04, 0.01], [0.01, 0.09]]), stamp_ns=1_500_000_000)


def test_bearing_is_in_mrad() -> None:
    """Azimuth, elevation, 0."""
    message = bearing_message(BEARING, 'optical')
    assert (message.vector.x, message.vector.y, message.vector.z) == (120.0, -75.0, 0.0)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert message.header.frame_id == 'optical'


def test_centroid_is_in_pixels() -> None:
    """x, y, 0."""
    location = Location(1.5, 2.5, np.eye(2), 1, 1, 1, 1, 1, 0, stamp_ns=1)
    message = centroid_message(location, 'optical')
    assert (message.point.x, message.point.y, message.point.z) == (1.5, 2.5, 0.0)


def test_ray_turns_the_optical_axis_onto_the_target() -> None:
    """The turned z axis has the azimuth and elevation of the bearing."""
    turn = ray_message(BEARING, 'optical').pose.pose.orientation
    x, y, z = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply([0, 0, 1])
    assert 1e3 * np.arctan2(x, z) == pytest.approx(BEARING.azimuth)
    assert 1e3 * np.arctan2(-y, np.hypot(x, z)) == pytest.approx(BEARING.elevation)


def test_ray_covariance_is_in_rad2_about_x_and_y() -> None:
    """Elevation about x, azimuth about y; the roll is unknown: spread over the circle."""
    covariance = np.array(ray_message(BEARING, 'optical').pose.covariance).reshape(6, 6)
    np.testing.assert_allclose(covariance[3:5, 3:5], [[9e-8, 1e-8], [1e-8, 4e-8]])
    assert covariance[5, 5] == pytest.approx(np.pi**2 / 3)
    assert (covariance[:3] == 0).all()


def test_noise_there_and_back() -> None:
    """Gain in x, read noise in y, black level in z, and what is no noise is refused."""
    message = noise_message(SensorNoise(3.5, 1.2, 240.0), 1_500_000_000, 'optical')
    assert (message.vector.x, message.vector.y, message.vector.z) == (3.5, 1.2, 240.0)
    assert to_noise(message) == SensorNoise(3.5, 1.2, 240.0)
    for field, value in (
        ('x', 0.0), ('x', np.inf), ('x', np.nan), ('y', -1.0), ('y', np.nan), ('z', np.nan),
        ('z', np.inf),
    ):
        wrong = noise_message(SensorNoise(3.5, 1.2), 1, 'optical')
        setattr(wrong.vector, field, value)
        with pytest.raises(MessageError, match='must be from 0.001 to 1e.06, from 0 to 10000'):
            to_noise(wrong)

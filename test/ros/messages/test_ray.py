"""Rays there and back, and what is no turn."""

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
import numpy as np
import pytest

BEARING = Bearing(120.0, -75.0, np.array([[0.04, 0.01], [0.01, 0.09]]), stamp_ns=1_500_000_000)


@pytest.mark.parametrize('azimuth, elevation', [
    (120.0, -75.0), (0.0, 0.0), (-3000.0, 1500.0), (1e-6, -1e-6), (1570.0, 10.0),
])
def test_ray_there_and_back(azimuth: float, elevation: float) -> None:
    """To rounding of the doubles, all round the camera."""
    bearing = Bearing(azimuth, elevation, BEARING.covariance, stamp_ns=-1_500_000_001)
    found = to_bearing(ray_message(bearing, 'optical'))
    # 1e-12 rad near the pole, where elevation is the arc tangent of a small ratio.
    assert found.azimuth == pytest.approx(azimuth, abs=1e-9)
    assert found.elevation == pytest.approx(elevation, abs=1e-9)
    np.testing.assert_allclose(found.covariance, bearing.covariance, rtol=1e-12)
    assert found.stamp_ns == bearing.stamp_ns


@pytest.mark.parametrize('w', [np.nan, np.inf, 0.0, 2.0])
def test_what_is_no_turn_is_no_bearing(w: float) -> None:
    """A quaternion has the length 1."""
    message = ray_message(BEARING, 'optical')
    message.pose.pose.orientation.w = w
    with pytest.raises(MessageError, match='must have length 1'):
        to_bearing(message)

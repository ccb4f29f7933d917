"""A track goes on along a straight line, and is known the less the longer it does."""

from blob_tracker.tracking import Track
from blob_tracker.tracking.extrapolation import extrapolated
import numpy as np

STATE = np.array([10.0, -5.0, 100.0, 40.0, 7.0, 8.0])
TRACK = Track(10**9, STATE, np.diag([1.0, 2.0, 300.0, 400.0, 5.0, 6.0]))


def test_angles_and_covariance_after_a_tenth_of_a_second() -> None:
    """Of a track that has accelerations as well: they are left out."""
    later = extrapolated(TRACK, 10**9 + 10**8)
    assert later.stamp_ns == 10**9 + 10**8
    np.testing.assert_allclose(later.state, [20.0, -1.0, 100.0, 40.0])
    np.testing.assert_allclose(later.angle_covariance, np.diag([4.0, 6.0]))
    np.testing.assert_allclose(later.rate_covariance, np.diag([300.0, 400.0]))
    np.testing.assert_array_equal(later.covariance, later.covariance.T)


def test_at_its_own_stamp_it_is_what_it_was() -> None:
    """But for the accelerations."""
    same = extrapolated(TRACK, 10**9)
    np.testing.assert_array_equal(same.state, STATE[:4])
    np.testing.assert_array_equal(same.angle_covariance, TRACK.angle_covariance)

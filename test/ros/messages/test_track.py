"""target/track and target/bearing_predicted: units, signs, and the way back."""

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.track import (
    prediction_message, stamp_offset_of, to_track, track_message,
)
from blob_tracker.tracking import Track
import numpy as np
import pytest

COVARIANCE = np.diag([0.04, 0.09, 4.0, 9.0, 1.0, 1.0])
COVARIANCE[0, 1] = COVARIANCE[1, 0] = 0.01
COVARIANCE[2, 3] = COVARIANCE[3, 2] = -1.0
STATE = np.array([120.0, -75.0, 30.0, -40.0, 1.0, 2.0])
TRACK = Track(1_500_000_000, STATE, COVARIANCE)


def test_prediction_is_in_mrad_at_its_instant() -> None:
    """Azimuth, elevation, 0."""
    message = prediction_message(TRACK, 'base')
    assert (message.vector.x, message.vector.y, message.vector.z) == (120.0, -75.0, 0.0)
    assert (to_ns(message.header.stamp), message.header.frame_id) == (1_500_000_000, 'base')


def test_track_has_rates_about_x_and_y_in_rad() -> None:
    """Elevation about x, azimuth about y, as the angles."""
    message = track_message(TRACK, 'optical', 'target')
    assert (message.header.frame_id, message.child_frame_id) == ('optical', 'target')
    angular = message.twist.twist.angular
    assert (angular.x, angular.y, angular.z) == pytest.approx((-0.04, 0.03, 0.0))
    covariance = np.array(message.twist.covariance).reshape(6, 6)
    np.testing.assert_allclose(covariance[3:5, 3:5], [[9e-6, -1e-6], [-1e-6, 4e-6]])
    assert (covariance[5] == 0).all() and (covariance[:3] == 0).all()


def test_track_there_and_back() -> None:
    """Angles, rates, and the covariance of each pair."""
    track = to_track(track_message(TRACK, 'optical', 'target'))
    assert track.stamp_ns == TRACK.stamp_ns
    np.testing.assert_allclose(track.state, STATE[:4], rtol=1e-12)
    np.testing.assert_allclose(track.angle_covariance, TRACK.angle_covariance, rtol=1e-12)
    np.testing.assert_allclose(track.rate_covariance, TRACK.rate_covariance, rtol=1e-12)
    assert (track.covariance[:2, 2:] == 0.0).all()


def test_what_is_no_number_is_refused() -> None:
    """In the turn, in the rates and in either covariance."""
    for spoil in (
        lambda m: setattr(m.pose.pose.orientation, 'w', np.nan),
        lambda m: setattr(m.twist.twist.angular, 'x', np.inf),
        lambda m: m.pose.covariance.__setitem__(21, np.nan),
        lambda m: m.twist.covariance.__setitem__(28, np.inf),
    ):
        message = track_message(TRACK, 'optical', 'target')
        spoil(message)
        with pytest.raises(MessageError, match='length 1|must be finite'):
            to_track(message)


def test_the_offset_of_the_stamps_there_and_back() -> None:
    """To the ns or so, with the age of UTC too; what is none is refused."""
    for offset in (0.0, 37.0, -1.79e9):
        message = track_message(TRACK, 'optical', 'target', stamp_offset=offset)
        assert stamp_offset_of(message) == offset
        assert to_track(message).stamp_ns == TRACK.stamp_ns
    for wrong in (np.nan, np.inf, 1e12):
        message.twist.twist.linear.z = wrong
        with pytest.raises(MessageError, match='offset of the stamps'):
            stamp_offset_of(message)

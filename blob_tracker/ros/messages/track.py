"""Track to the messages on target/track and target/bearing_predicted, and back."""

from __future__ import annotations

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.stamp import fill_ns, to_ns
from blob_tracker.ros.messages.target import (
    about_x_and_y, ray_covariance, to_angles, to_covariance, turn_onto,
)
from blob_tracker.tracking import Track
from blob_tracker.units import MRAD
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np

MOST_OFFSET_S = 2e9  # as `stamp_offset` of the tracker


def prediction_message(
    track: Track, frame_id: str, message: Vector3Stamped | None = None
) -> Vector3Stamped:
    """Return target/bearing_predicted: x azimuth mrad, y elevation mrad; filled again."""
    message = Vector3Stamped() if message is None else message
    fill_ns(message.header.stamp, track.stamp_ns)
    message.header.frame_id = frame_id
    message.vector.x = track.azimuth
    message.vector.y = track.elevation
    return message


def track_message(
    track: Track, frame_id: str, target: str, message: Odometry | None = None,
    *, stamp_offset: float = 0.0,
) -> Odometry:
    """
    Return target/track: the turn that takes the z axis onto the target, and its rates.

    Parameters
    ----------
    track : Track
        As the camera sees it.
    frame_id : str
        Name of the optical frame.
    target : str
        Name of the target: that of the child frame.
    message : Odometry, optional
        Is filled again.
    stamp_offset : float
        What was taken off the camera's stamps, s.

    Returns
    -------
    Odometry
        The pose is that of target/ray. In the twist, angular x is the rate of the elevation and
        y that of the azimuth, rad/s, with their covariance; linear z is the offset of the stamps.

    """
    message = Odometry() if message is None else message
    fill_ns(message.header.stamp, track.stamp_ns)
    message.header.frame_id = frame_id
    message.child_frame_id = target
    turn_onto(track.azimuth, track.elevation, message.pose.pose.orientation)
    message.pose.covariance = ray_covariance(track.angle_covariance)
    azimuth_rate, elevation_rate = track.rate
    message.twist.twist.angular.x = MRAD * float(elevation_rate)
    message.twist.twist.angular.y = MRAD * float(azimuth_rate)
    message.twist.twist.linear.z = stamp_offset
    message.twist.covariance = about_x_and_y(track.rate_covariance)
    return message


def to_track(message: Odometry) -> Track:
    """
    Return the track of a message on target/track.

    Its state is angles and rates; of their covariance the message leaves out that of one with
    the other, which is zero here.

    Raises
    ------
    MessageError
        Where a number of it can be none.

    """
    azimuth, elevation = to_angles(message.pose.pose.orientation)
    rates = message.twist.twist.angular
    state = np.array([azimuth, elevation, rates.y / MRAD, rates.x / MRAD])
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = to_covariance(message.pose.covariance)
    covariance[2:, 2:] = to_covariance(message.twist.covariance)
    if not (np.isfinite(state).all() and np.isfinite(covariance).all()):
        raise MessageError(
            f'azimuth, elevation (mrad) and their rates (mrad/s) are {state}; they and their '
            'covariance must be finite'
        )
    return Track(to_ns(message.header.stamp), state, covariance)


def stamp_offset_of(message: Odometry) -> float:
    """
    Return what was taken off the camera's stamps on target/track, s.

    Raises
    ------
    MessageError
        Where it can be none.

    """
    offset = float(message.twist.twist.linear.z)
    if not abs(offset) <= MOST_OFFSET_S:
        raise MessageError(
            f'the offset of the stamps (twist.linear.z) is {offset} s; it must be within '
            f'{MOST_OFFSET_S:.0e} s'
        )
    return offset

"""Track to the messages on target/track and target/bearing_predicted, and back."""

from __future__ import annotations

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.ray import to_angles, to_covariance
from blob_tracker.ros.messages.serialised import serialised
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.target import about_x_and_y, NOWHERE, ray_covariance, turn_onto
from blob_tracker.tracking import Track
from blob_tracker.units import MRAD
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
from rclpy.serialization import deserialize_message

MOST_OFFSET_S = 2e9  # as `stamp_offset` of the tracker


def prediction_bytes(track: Track, frame_id: str) -> bytes:
    """Return target/bearing_predicted, serialised: x azimuth mrad, y elevation mrad."""
    return serialised(track.stamp_ns, (frame_id,), [track.azimuth, track.elevation, 0.0])


def prediction_message(track: Track, frame_id: str) -> Vector3Stamped:
    """Return the message of `prediction_bytes`."""
    message: Vector3Stamped = deserialize_message(
        prediction_bytes(track, frame_id), Vector3Stamped
    )
    return message


def track_bytes(track: Track, frame_id: str, target: str, *, stamp_offset: float = 0.0) -> bytes:
    """
    Return target/track, serialised: the turn that takes the z axis onto the target, its rates.

    The pose is that of target/ray. In the twist, angular x is the rate of the elevation and y that
    of the azimuth, rad/s, with their covariance; linear z is the offset of the stamps.

    Parameters
    ----------
    track : Track
        As the camera sees it.
    frame_id : str
        Name of the optical frame.
    target : str
        Name of the target: that of the child frame.
    stamp_offset : float
        What was taken off the camera's stamps, s.

    """
    azimuth_rate, elevation_rate = track.rate.tolist()
    return serialised(track.stamp_ns, (frame_id, target), [
        *NOWHERE, *turn_onto(track.azimuth, track.elevation),
        *ray_covariance(track.angle_covariance),
        0.0, 0.0, stamp_offset, MRAD * elevation_rate, MRAD * azimuth_rate, 0.0,
        *about_x_and_y(track.rate_covariance),
    ])


def track_message(
    track: Track, frame_id: str, target: str, *, stamp_offset: float = 0.0
) -> Odometry:
    """Return the message of `track_bytes`."""
    message: Odometry = deserialize_message(
        track_bytes(track, frame_id, target, stamp_offset=stamp_offset), Odometry
    )
    return message


def to_track(message: Odometry) -> Track:
    """
    Return the track of a message on target/track.

    Its state is angles and rates; of their covariance the message leaves out that of one with
    the other, which is zero here.

    Raises
    ------
    MessageError
        If a number of it can be none.

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
        If it can be none.

    """
    offset = float(message.twist.twist.linear.z)
    if not abs(offset) <= MOST_OFFSET_S:
        raise MessageError(
            f'the offset of the stamps (twist.linear.z) is {offset} s; it must be within '
            f'{MOST_OFFSET_S:.0e} s'
        )
    return offset

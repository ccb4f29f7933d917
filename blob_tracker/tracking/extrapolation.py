"""A track at a later instant, of nothing but its angles and rates."""

from __future__ import annotations

from blob_tracker.tracking.track import Track
import numpy as np


def extrapolated(track: Track, stamp_ns: int) -> Track:
    """
    Return a track at another instant, as if the rates of its angles were constant.

    After the time t, z = z_0 + t r_0 and C = C_0 + t^2 R_0. What the target may do meanwhile, and
    what its angle has to do with its rate, is left out: `Tracker.seen_at` knows both, and this is
    for those who have the track alone, over a frame or two.

    Parameters
    ----------
    track : Track
        Filtered.
    stamp_ns : int
        ns of ROS time.

    Returns
    -------
    Track
        Angles and rates with that stamp.

    """
    time = 1e-9 * (stamp_ns - track.stamp_ns)
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = track.angle_covariance + time**2 * track.rate_covariance
    covariance[:2, 2:] = covariance[2:, :2] = time * track.rate_covariance
    covariance[2:, 2:] = track.rate_covariance
    angles = np.array([track.azimuth, track.elevation]) + time * track.rate
    return Track(stamp_ns, np.concatenate([angles, track.rate]), covariance)

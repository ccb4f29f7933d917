"""A bearing at an instant between two that were measured."""

from __future__ import annotations

import math

from blob_tracker.types import Bearing
from blob_tracker.units import MRAD_PER_RAD
import numpy as np

TURN_MRAD = 2.0 * math.pi * MRAD_PER_RAD


def interpolated(
    before: Bearing, after: Bearing, stamp_ns: int, acceleration: float
) -> Bearing:
    """
    Return the bearing on the straight line between two others.

    With the part w of the time h between the two that has passed,

        z = (1 - w) z_0 + w z_1
        C = (1 - w)^2 C_0 + w^2 C_1 + a^2 w^2 (1 - w)^2 h^3 / 3  I

    The last term is what a motion strays from the line whose angular acceleration is white noise
    of the spectral density a^2: int G(s)^2 ds, with Green's function G of x'' between two fixed
    ends.

    Parameters
    ----------
    before, after : Bearing
        Measured at different instants, the earlier one first.
    stamp_ns : int
        The instant, ns of ROS time, from that of `before` to that of `after`.
    acceleration : float
        a: standard deviation of the change of the angular rate over one second, mrad/s^2.

    Returns
    -------
    Bearing
        With that stamp.

    Raises
    ------
    ValueError
        Where the instant does not lie between the two.

    """
    if not before.stamp_ns <= stamp_ns <= after.stamp_ns or before.stamp_ns == after.stamp_ns:
        raise ValueError(
            f'the instant {stamp_ns} ns does not lie between the bearings at {before.stamp_ns} ns '
            f'and {after.stamp_ns} ns'
        )
    interval = 1e-9 * (after.stamp_ns - before.stamp_ns)
    part = (stamp_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
    way = math.remainder(after.azimuth - before.azimuth, TURN_MRAD)
    strayed = acceleration**2 * (part * (1.0 - part)) ** 2 * interval**3 / 3.0
    return Bearing(
        azimuth=math.remainder(before.azimuth + part * way, TURN_MRAD),
        elevation=(1.0 - part) * before.elevation + part * after.elevation,
        covariance=(1.0 - part) ** 2 * before.covariance
        + part**2 * after.covariance
        + strayed * np.eye(2),
        stamp_ns=stamp_ns,
    )

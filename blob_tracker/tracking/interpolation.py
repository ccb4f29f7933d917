"""A bearing at an instant between two that were measured, and what it strays from the light's."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD_PER_RAD
import numpy as np

TURN_MRAD = 2.0 * math.pi * MRAD_PER_RAD


def interpolated(before: Bearing, after: Bearing, stamp_ns: int) -> Bearing:
    """
    Return the bearing on the straight line between two others.

    With the part w of the time h between the two that has passed,

        z = (1 - w) z_0 + w z_1
        C = (1 - w)^2 C_0 + w^2 C_1

    What a light that does not move evenly strays from that line is not in it: see `strays`.

    Parameters
    ----------
    before, after : Bearing
        Measured at different instants, the earlier one first.
    stamp_ns : int
        The instant, ns of ROS time, from that of `before` to that of `after`.

    Returns
    -------
    Bearing
        With that stamp.

    Raises
    ------
    ValueError
        If the instant does not lie between the two.

    """
    if not before.stamp_ns <= stamp_ns <= after.stamp_ns or before.stamp_ns == after.stamp_ns:
        raise ValueError(
            f'the instant {stamp_ns} ns does not lie between the bearings at {before.stamp_ns} ns '
            f'and {after.stamp_ns} ns'
        )
    part = (stamp_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
    way = math.remainder(after.azimuth - before.azimuth, TURN_MRAD)
    return Bearing(
        azimuth=math.remainder(before.azimuth + part * way, TURN_MRAD),
        elevation=(1.0 - part) * before.elevation + part * after.elevation,
        covariance=(1.0 - part) ** 2 * before.covariance + part**2 * after.covariance,
        stamp_ns=stamp_ns,
    )


def strays(since: Array, until: Array) -> Array:
    """
    Return what a motion strays from straight lines, at an instant that lies on each of them.

    Where the acceleration is white noise of spectral density 1, the covariance of what it strays
    from the lines i and j is

        int G_i(s) G_j(s) ds = (q_i q_j F(p_i, p_j) + p_i p_j F(q_i, q_j)) / (h_i h_j)
        F(a, b) = a^2 (3 b - a) / 6,    a <= b

    with Green's function G of x'' between two fixed ends, the time p since the one end, q until
    the other and h = p + q; of a line itself p^2 q^2 / 3 h.

    Parameters
    ----------
    since, until : (n,) arrays
        p and q of each line, s; both 0 where the instant itself was measured.

    Returns
    -------
    (n, n) array
        s^3: times the acceleration's density, the square of a change of speed in one second.

    """
    def folded(times: Array) -> Array:
        shorter = np.minimum(times[:, None], times)
        return np.asarray(shorter**2 * (3.0 * np.maximum(times[:, None], times) - shorter) / 6.0)

    lengths = since + until
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    return np.asarray(
        (np.outer(until, until) * folded(since) + np.outer(since, since) * folded(until))
        / np.outer(lengths, lengths)
    )

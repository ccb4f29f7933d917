"""A bearing with the place of the camera at its stamp, and one between two of them."""

from __future__ import annotations

from dataclasses import replace
import math
from typing import NamedTuple

from blob_tracker.tracking.camera_pose import CameraPose
from blob_tracker.tracking.interpolation import interpolated
from blob_tracker.tracking.rays import directions, tangents
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np


class Sight(NamedTuple):
    """
    What a camera saw, and from where.

    Parameters
    ----------
    bearing : Bearing
        In the camera's optical frame.
    pose : CameraPose
        Of the camera at the bearing's stamp.

    Examples
    --------
    Of a camera at the origin of the frame of reference:

    >>> import numpy as np
    >>> bearing = Bearing(50.0, 0.0, 0.01 * np.eye(2), stamp_ns=16_666_667)
    >>> Sight(bearing, CameraPose(np.zeros(3))).stamp_ns
    16666667

    """

    bearing: Bearing
    pose: CameraPose

    @property
    def stamp_ns(self) -> int:
        """Return the bearing's stamp, ns."""
        return self.bearing.stamp_ns


def between(before: Sight, after: Sight, stamp_ns: int) -> Sight:
    """
    Return what a camera would have seen at an instant between two others.

    Of a camera that moves the later direction is taken in the axes that it had at the earlier one,
    in which the light alone moves; its place is on the line between the two.

    Parameters
    ----------
    before, after : Sight
        Of the same camera, the earlier one first.
    stamp_ns : int
        See `interpolated`.

    """
    pose = before.pose
    if after.pose is pose:
        return Sight(interpolated(before.bearing, after.bearing, stamp_ns), pose)
    part = (stamp_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
    return Sight(
        interpolated(before.bearing, _in_axes_of(pose, after), stamp_ns),
        replace(pose, position=(1.0 - part) * pose.position + part * after.pose.position),
    )


def _in_axes_of(pose: CameraPose, sight: Sight) -> Bearing:
    """Return a bearing as a camera sees it that stands at the same place, turned otherwise."""
    bearing = sight.bearing
    angles = MRAD * np.array([bearing.azimuth, bearing.elevation])
    turn = pose.rotation.T @ sight.pose.rotation
    x, y, z = turn @ directions(angles)
    level = math.hypot(x, z)
    by_direction = np.array([
        [z / level**2, 0.0, -x / level**2],
        [x * y / level, -level, z * y / level],
    ])
    derivative = by_direction @ turn @ tangents(angles)
    return Bearing(
        azimuth=math.atan2(x, z) / MRAD,
        elevation=math.atan2(-y, level) / MRAD,
        covariance=derivative @ bearing.covariance @ derivative.T,
        stamp_ns=bearing.stamp_ns,
    )

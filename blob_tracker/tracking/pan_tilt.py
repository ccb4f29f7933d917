"""What a tracker asks of whatever knows how the camera is turned."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class PanTilt(Protocol):
    """
    How the camera is turned against the base at an instant, see `PanTiltAngles`.

    Each raises PlatformGap where the instant, ns of ROS time, is not covered.

    Examples
    --------
    `PanTiltAngles` is one: what is straight ahead of a camera that is panned by 0.1 rad is as far
    to the right in the base:

    >>> from blob_tracker.tracking import PanTiltAngles, Tracker
    >>> from blob_tracker.types import Bearing
    >>> pan_tilt = PanTiltAngles()
    >>> tracker = Tracker(pan_tilt=pan_tilt)
    >>> for stamp_ns in range(0, 100_000_000, 20_000_000):
    ...     pan_tilt.push(stamp_ns, pan=0.1, tilt=0.0)
    ...     _ = tracker.update(Bearing(0.0, 0.0, np.diag([1e-4, 1e-4]), stamp_ns))
    >>> round(tracker.at(stamp_ns).azimuth, 1)  # mrad
    100.0

    """

    def at(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return the (3, 3) turn that takes components in the camera to those in the base."""

    def rate_at(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return the camera's angular velocity against the base, (3,), in its axes, rad/s."""

    def variances_at(self, stamp_ns: int) -> tuple[float, float]:
        """Return the variances of azimuth and elevation that the turn adds, rad^2."""

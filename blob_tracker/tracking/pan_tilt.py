"""What a tracker asks of whatever knows how the camera is turned."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class PanTilt(Protocol):
    """
    How the camera is turned against the base at an instant, see `PanTiltAngles`.

    Each raises PlatformGap where the instant, ns of ROS time, is not covered.
    """

    def at(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return the (3, 3) turn that takes components in the camera to those in the base."""

    def rate_at(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return the camera's angular velocity against the base, (3,), in its axes, rad/s."""

    def variances_at(self, stamp_ns: int) -> tuple[float, float]:
        """Return the variances of azimuth and elevation that the turn adds, rad^2."""

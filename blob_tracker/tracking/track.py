"""Track: where the target is at an instant, how it moves, and how well that is known."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, sqrt

from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Track:
    """
    The target's direction and its motion at an instant.

    Parameters
    ----------
    stamp_ns : int
        The instant, ns of ROS time.
    state : (n,) array
        Azimuth and elevation, mrad; their rates, mrad/s; with the model `constant_acceleration`
        their accelerations, mrad/s^2.
    covariance : (n, n) array
        Of the state, symmetric and positive definite.

    Examples
    --------
    A direction known to 0.1 mrad along the azimuth, and to 0.2 mrad along the elevation:

    >>> track = Track(0, np.array([222.6, -265.5, 50.0, 0.0]), np.diag([0.01, 0.04, 1.0, 1.0]))
    >>> track.azimuth, track.rate.tolist()  # mrad, mrad/s
    (222.6, [50.0, 0.0])
    >>> round(track.sigma, 3)  # mrad
    0.2

    """

    stamp_ns: int
    state: NDArray[np.float64]
    covariance: NDArray[np.float64]

    @property
    def azimuth(self) -> float:
        """Azimuth, mrad, positive to the right."""
        return float(self.state[0])

    @property
    def elevation(self) -> float:
        """Elevation, mrad, positive up."""
        return float(self.state[1])

    @property
    def rate(self) -> NDArray[np.float64]:
        """Rates of azimuth and elevation, (2,), mrad/s."""
        return self.state[2:4]

    @property
    def angle_covariance(self) -> NDArray[np.float64]:
        """Covariance of azimuth and elevation, (2, 2), mrad^2."""
        return self.covariance[:2, :2]

    @property
    def rate_covariance(self) -> NDArray[np.float64]:
        """Covariance of their rates, (2, 2), mrad^2/s^2."""
        return self.covariance[2:4, 2:4]

    @property
    def sigma(self) -> float:
        """
        Largest standard deviation of the direction, mrad.

        On the sphere: that of azimuth counts by the cosine of the elevation, so that a target
        straight up, which has no azimuth, is not lost.
        """
        shrunk = cos(MRAD * self.elevation)
        (a, b), (_, c) = self.angle_covariance.tolist()
        a, b = shrunk * shrunk * a, shrunk * b
        return sqrt(0.5 * (a + c) + hypot(0.5 * (a - c), b))

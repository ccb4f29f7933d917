"""The pan/tilt's place, from the angles of its joints."""

from __future__ import annotations

from math import cos, isfinite, sin

from blob_tracker.tracking.errors import TrackingError
from blob_tracker.tracking.joint_angle import JointAngle
from blob_tracker.tracking.rotation import pan_tilt
from blob_tracker.tracking.validation import check_positive, check_stamp
import numpy as np
from numpy.typing import NDArray


class PanTiltAngles:
    """
    How the camera is turned against the base at an instant.

    Each joint has samples of its own. Its angle is linear in time between them; past the newest
    one it goes on at the last rate, which is taken over `joint_angle.SPAN_NS` or more.

    Parameters
    ----------
    hold : float
        Longest time, s, for which that is done, and between two samples.
    memory : float
        Time for which samples are kept, s; a late one within it is put in its place.
    sigma : float
        Standard deviation of either angle at an instant, rad: of the encoder's step, over
        sqrt(12), and of the bend between two samples. It is added to that of each bearing:
        without it a track of good bearings refuses what is right.
    acceleration : float
        Standard deviation of the joints' acceleration, rad/s^2, for how far off the angles are
        past the newest sample: 5 is half of what a swift pan/tilt has (100 degrees/s in 0.2 s).

    Raises
    ------
    TrackingError
        If hold or memory is not above 0, sigma or acceleration is below, or one of them is not
        finite.

    Examples
    --------
    A pan that turns at 1 rad/s, halfway between two samples:

    >>> pan_tilt = PanTiltAngles()
    >>> pan_tilt.push(0, pan=0.0, tilt=0.0)
    >>> pan_tilt.push(100_000_000, pan=0.1, tilt=0.0)
    >>> turn = pan_tilt.at(50_000_000)
    >>> round(float(np.arcsin(turn[0, 2])), 3)  # rad
    0.05
    >>> pan_tilt.at(1_000_000_000)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.PlatformGap: ...angle of pan is 0.900 s old; it holds for 0.2 s

    """

    def __init__(
        self,
        hold: float = 0.2,
        memory: float = 2.0,
        *,
        sigma: float = 0.0,
        acceleration: float = 5.0,
    ) -> None:
        check_positive({'hold': hold, 'memory': memory}, ' s')
        for name, value, unit in (
            ('sigma', sigma, 'rad'), ('acceleration', acceleration, 'rad/s^2')
        ):
            if not (value >= 0.0 and isfinite(value)):
                raise TrackingError(f'{name} is {value} {unit}; it must be 0 or more and finite')
        self.hold = hold
        self.memory = memory
        self.sigma = sigma
        self.acceleration = acceleration
        self._pan, self._tilt = (
            JointAngle(name, round(1e9 * hold), round(1e9 * memory)) for name in ('pan', 'tilt')
        )

    @property
    def newest_ns(self) -> int | None:
        """Until when both angles are known, ns; None if one has no sample."""
        pan_ns, tilt_ns = self._pan.newest_ns, self._tilt.newest_ns
        return None if pan_ns is None or tilt_ns is None else min(pan_ns, tilt_ns)

    def reset(self) -> None:
        """Forget all samples."""
        self._pan.reset()
        self._tilt.reset()

    def push(self, stamp_ns: int, pan: float | None, tilt: float | None) -> None:
        """
        Take a sample of one joint, or of both.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.
        pan, tilt : float or None
            rad; the boresight has azimuth pan and elevation tilt in the base. None for a joint of
            which there is no news.

        Raises
        ------
        TrackingError
            If an angle or the stamp is none that can be, or there is another with this stamp.
        StampJump
            If the stamp is from before the memory.

        """
        check_stamp(stamp_ns)
        for joint, angle in ((self._pan, pan), (self._tilt, tilt)):
            if angle is not None:
                joint.push(stamp_ns, angle)

    def at(self, stamp_ns: int) -> NDArray[np.float64]:
        """
        Return how the camera is turned, (3, 3): takes components in the camera to the base.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.

        Raises
        ------
        PlatformGap
            If the samples do not cover the instant, with a reason.

        """
        return pan_tilt(self._pan.at(stamp_ns).angle, self._tilt.at(stamp_ns).angle)

    def rate_at(self, stamp_ns: int) -> NDArray[np.float64]:
        """
        Return the camera's angular velocity against the base, (3,), in the base's axes, rad/s.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.

        Raises
        ------
        PlatformGap
            As `at` does.

        """
        (pan, pan_rate), (_, tilt_rate) = self._pan.at(stamp_ns), self._tilt.at(stamp_ns)
        return np.array([cos(pan) * tilt_rate, pan_rate, -sin(pan) * tilt_rate])

    def variances_at(self, stamp_ns: int) -> tuple[float, float]:
        """
        Return the variances of pan and tilt at an instant, rad^2.

        By t past the newest sample, with the rate over the interval h before it, an acceleration a
        puts the angle off by a t (t + h) / 2, and the errors of both samples, each of the variance
        s^2, are in it by 1 + t/h and t/h:

            s^2 ((1 + t/h)^2 + (t/h)^2) + (a t (t + h) / 2)^2

        Where no samples tell a rate, s^2 + (`joint_angle.UNKNOWN_RATE_RAD_S` t)^2; between samples
        s^2.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time, that `at` has an answer for.

        """
        pan, tilt = (
            joint.variance_at(stamp_ns, self.sigma, self.acceleration)
            for joint in (self._pan, self._tilt)
        )
        return pan, tilt

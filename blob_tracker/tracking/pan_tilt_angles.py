"""The pan/tilt's place, from the angles of its joints."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from math import cos, isfinite, pi, remainder, sin

from blob_tracker.tracking.errors import check_stamp, PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.rotation import pan_tilt
import numpy as np
from numpy.typing import NDArray


class PanTiltAngles:
    """
    How the camera is turned against the base at an instant.

    The angles are linear in time between samples; past the newest one they go on at the last
    rate.

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

    Raises
    ------
    TrackingError
        Where hold or memory is not above 0, sigma is below, or one of them is not finite.

    """

    def __init__(self, hold: float = 0.2, memory: float = 2.0, *, sigma: float = 0.0) -> None:
        for name, value in (('hold', hold), ('memory', memory)):
            if not (value > 0.0 and isfinite(value)):
                raise TrackingError(f'{name} is {value} s; it must be above 0 and finite')
        if not (sigma >= 0.0 and isfinite(sigma)):
            raise TrackingError(f'sigma is {sigma} rad; it must be 0 or more and finite')
        self.hold = hold
        self.memory = memory
        self.sigma = sigma
        self._hold_ns, self._memory_ns = round(1e9 * hold), round(1e9 * memory)
        self._stamps: list[int] = []
        self._angles: list[tuple[float, float]] = []

    def reset(self) -> None:
        """Forget all samples."""
        self._stamps.clear()
        self._angles.clear()

    def push(self, stamp_ns: int, pan: float, tilt: float) -> None:
        """
        Take a sample.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.
        pan, tilt : float
            rad; the boresight has azimuth pan and elevation tilt in the base.

        Raises
        ------
        TrackingError
            Where an angle or the stamp is none that can be, or there is a sample with this stamp.
        StampJump
            Where the stamp is from before the memory.

        """
        check_stamp(stamp_ns)
        if not (isfinite(pan) and isfinite(tilt)):
            raise TrackingError(f'pan and tilt are {pan} and {tilt} rad; both must be finite')
        place = len(self._stamps)
        if self._stamps and stamp_ns <= self._stamps[-1]:
            late = self._stamps[-1] - stamp_ns
            if late > self._memory_ns:
                raise StampJump(
                    f'the stamp of the joint angles is {1e-9 * late:.3f} s before the newest one; '
                    f'at most {self.memory:g} s can be late'
                )
            place = bisect_left(self._stamps, stamp_ns)
            if self._stamps[place] == stamp_ns:
                raise TrackingError(f'there are joint angles with the stamp {stamp_ns} ns')
        self._stamps.insert(place, stamp_ns)
        self._angles.insert(place, (pan, tilt))
        forgotten = bisect_left(self._stamps, self._stamps[-1] - self._memory_ns)
        del self._stamps[:forgotten], self._angles[:forgotten]

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
            Where the samples do not cover the instant, with a reason.

        """
        (pan, tilt), _ = self._interpolated(stamp_ns)
        return pan_tilt(pan, tilt)

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
        (pan, _), (pan_rate, tilt_rate) = self._interpolated(stamp_ns)
        return np.array([cos(pan) * tilt_rate, pan_rate, -sin(pan) * tilt_rate])

    def _interpolated(self, stamp_ns: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return pan and tilt at an instant, rad, and their rates, rad/s."""
        stamps = self._stamps
        if not stamps:
            raise PlatformGap('no joint angles have come')
        after = bisect_right(stamps, stamp_ns)
        if after == 0:
            raise PlatformGap(
                f'the joint angles of {1e-9 * (stamps[-1] - stamp_ns):.3f} s before the newest '
                'ones are not kept'
            )
        if stamp_ns - stamps[-1] > self._hold_ns:
            raise PlatformGap(
                f'the newest joint angles are {1e-9 * (stamp_ns - stamps[-1]):.3f} s old; they '
                f'hold for {self.hold:g} s'
            )
        if len(stamps) == 1:
            return self._angles[0], (0.0, 0.0)
        end = min(after, len(stamps) - 1)
        interval = stamps[end] - stamps[end - 1]
        if interval > self._hold_ns:
            if after < len(stamps):
                raise PlatformGap(f'joint angles are more than {self.hold:g} s apart')
            return self._angles[-1], (0.0, 0.0)
        (pan0, tilt0), (pan1, tilt1) = self._angles[end - 1], self._angles[end]
        # The short way round: a joint that turns for ever may be read modulo a turn.
        pan_step, tilt_step = remainder(pan1 - pan0, 2.0 * pi), remainder(tilt1 - tilt0, 2.0 * pi)
        share, seconds = (stamp_ns - stamps[end - 1]) / interval, 1e-9 * interval
        return (
            (pan0 + share * pan_step, tilt0 + share * tilt_step),
            (pan_step / seconds, tilt_step / seconds),
        )

"""The pan/tilt's place, from the angles of its joints."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from math import cos, isfinite, remainder, sin, tau

from blob_tracker.tracking.errors import PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.rotation import pan_tilt
from blob_tracker.tracking.validation import check_positive, check_stamp
import numpy as np
from numpy.typing import NDArray

# ns over which a rate is taken at least: over less it is the encoder's step and the stamps' jitter
# (1e-4 rad in 20 us are 5 rad/s). A little less than the interval of 100 Hz, which is common.
SPAN_NS = 8_000_000
# Standard deviation of a rate that no samples tell: what a pan/tilt turns at when it does.
UNKNOWN_RATE_RAD_S = 1.0


class PanTiltAngles:
    """
    How the camera is turned against the base at an instant.

    The angles are linear in time between samples; past the newest one they go on at the last
    rate, which is taken over `SPAN_NS` or more.

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
        Where hold or memory is not above 0, sigma or acceleration is below, or one of them is not
        finite.

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
        self._hold_ns, self._memory_ns = round(1e9 * hold), round(1e9 * memory)
        self._stamps: list[int] = []
        self._angles: list[tuple[float, float]] = []

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest sample, ns; None where there is none."""
        return self._stamps[-1] if self._stamps else None

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

    def variance_at(self, stamp_ns: int) -> float:
        """
        Return the variance of either angle at an instant, rad^2.

        By t past the newest sample, with the rate over the interval h before it, an acceleration a
        puts the angle off by a t (t + h) / 2, and the errors of both samples, each of the variance
        s^2, are in it by 1 + t/h and t/h:

            s^2 ((1 + t/h)^2 + (t/h)^2) + (a t (t + h) / 2)^2

        Where no samples tell a rate, s^2 + (`UNKNOWN_RATE_RAD_S` t)^2; between samples s^2.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time, that `at` has an answer for.

        """
        ahead = 1e-9 * (stamp_ns - self._stamps[-1])
        if ahead <= 0.0:
            return self.sigma**2
        begin = self._begin(len(self._stamps) - 1)
        if begin is None:
            return self.sigma**2 + (UNKNOWN_RATE_RAD_S * ahead) ** 2
        interval = 1e-9 * (self._stamps[-1] - self._stamps[begin])
        share = ahead / interval
        strayed = 0.5 * self.acceleration * ahead * (ahead + interval)
        return self.sigma**2 * ((1.0 + share) ** 2 + share**2) + strayed**2

    def _begin(self, end: int) -> int | None:
        """Return the sample from which to one the rate is taken; None where there is none."""
        stamps = self._stamps
        begin = bisect_right(stamps, stamps[end] - SPAN_NS) - 1
        return begin if begin >= 0 and stamps[end] - stamps[begin] <= self._hold_ns else None

    def _rates(self, begin: int, end: int) -> tuple[float, float]:
        """Return the rates of pan and tilt from one sample to another, rad/s."""
        seconds = 1e-9 * (self._stamps[end] - self._stamps[begin])
        (pan0, tilt0), (pan1, tilt1) = self._angles[begin], self._angles[end]
        # The short way round: a joint that turns for ever may be read modulo a turn.
        return remainder(pan1 - pan0, tau) / seconds, remainder(tilt1 - tilt0, tau) / seconds

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
        pan, tilt = self._angles[after - 1]
        since = 1e-9 * (stamp_ns - stamps[after - 1])
        if after == len(stamps):
            begin = self._begin(after - 1)
            if begin is None:
                return (pan, tilt), (0.0, 0.0)
            rates = self._rates(begin, after - 1)
            return (pan + since * rates[0], tilt + since * rates[1]), rates
        if stamps[after] - stamps[after - 1] > self._hold_ns:
            raise PlatformGap(f'joint angles are more than {self.hold:g} s apart')
        line = self._rates(after - 1, after)
        begin = self._begin(after)
        rates = line if begin is None else self._rates(begin, after)
        return (pan + since * line[0], tilt + since * line[1]), rates

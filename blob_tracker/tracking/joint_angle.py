"""The angle of one joint at any instant, from its samples."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from math import isfinite, remainder, tau
from typing import NamedTuple

from blob_tracker.tracking.errors import PlatformGap, StampJump, TrackingError

# ns over which a rate is taken at least: over less it is the encoder's step and the stamps' jitter
# (1e-4 rad in 20 us are 5 rad/s). A little less than the interval of 100 Hz, which is common.
SPAN_NS = 8_000_000
# Standard deviation of a rate that no samples tell: what a pan/tilt turns at when it does.
UNKNOWN_RATE_RAD_S = 1.0


class Turning(NamedTuple):
    """An angle at an instant, rad, and its rate, rad/s."""

    angle: float
    rate: float


class JointAngle:
    """
    Where one joint stands at an instant.

    Parameters
    ----------
    name : str
        What the sentences call it.
    hold_ns, memory_ns : int
        Longest time past the newest sample, and between two; and for which samples are kept, ns.

    """

    def __init__(self, name: str, hold_ns: int, memory_ns: int) -> None:
        self._name = name
        self._hold_ns, self._memory_ns = hold_ns, memory_ns
        self._stamps: list[int] = []
        self._angles: list[float] = []

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest sample, ns; None if there is none."""
        return self._stamps[-1] if self._stamps else None

    def reset(self) -> None:
        """Forget all samples."""
        self._stamps.clear()
        self._angles.clear()

    def push(self, stamp_ns: int, angle: float) -> None:
        """
        Take a sample, rad; one that says again what is known, at the same stamp, is no news.

        Raises
        ------
        TrackingError
            If the angle cannot be, or there is another one with this stamp.
        StampJump
            If the stamp is from before the memory.

        """
        if not isfinite(angle):
            raise TrackingError(f'{self._name} is {angle} rad; it must be finite')
        place = len(self._stamps)
        if self._stamps and stamp_ns <= self._stamps[-1]:
            late = self._stamps[-1] - stamp_ns
            if late > self._memory_ns:
                raise StampJump(
                    f'the stamp of {self._name} is {1e-9 * late:.3f} s before the newest one; '
                    f'at most {1e-9 * self._memory_ns:g} s can be late'
                )
            place = bisect_left(self._stamps, stamp_ns)
            if self._stamps[place] == stamp_ns:
                if self._angles[place] == angle:
                    return
                raise TrackingError(
                    f'there is another angle of {self._name} with the stamp {stamp_ns} ns'
                )
        self._stamps.insert(place, stamp_ns)
        self._angles.insert(place, angle)
        forgotten = bisect_left(self._stamps, self._stamps[-1] - self._memory_ns)
        del self._stamps[:forgotten], self._angles[:forgotten]

    def at(self, stamp_ns: int) -> Turning:
        """
        Return the angle at an instant, ns, and its rate.

        Raises
        ------
        PlatformGap
            If the samples do not cover the instant, with a reason.

        """
        stamps = self._stamps
        if not stamps:
            raise PlatformGap(f'no angle of {self._name} has come')
        after = bisect_right(stamps, stamp_ns)
        if after == 0:
            raise PlatformGap(
                f'{self._name} of {1e-9 * (stamps[-1] - stamp_ns):.3f} s before its newest angle '
                'is not kept'
            )
        if stamp_ns - stamps[-1] > self._hold_ns:
            raise PlatformGap(
                f'the newest angle of {self._name} is {1e-9 * (stamp_ns - stamps[-1]):.3f} s old; '
                f'it holds for {1e-9 * self._hold_ns:g} s'
            )
        angle = self._angles[after - 1]
        since = 1e-9 * (stamp_ns - stamps[after - 1])
        if after == len(stamps):
            begin = self._begin(after - 1)
            if begin is None:
                return Turning(angle, 0.0)
            rate = self._rate(begin, after - 1)
            return Turning(angle + since * rate, rate)
        if stamps[after] - stamps[after - 1] > self._hold_ns:
            raise PlatformGap(
                f'angles of {self._name} are more than {1e-9 * self._hold_ns:g} s apart'
            )
        line = self._rate(after - 1, after)
        begin = self._begin(after)
        rate = line if begin is None else self._rate(begin, after)
        return Turning(angle + since * line, rate)

    def variance_at(self, stamp_ns: int, sigma: float, acceleration: float) -> float:
        """Return the variance of the angle, rad^2; see `PanTiltAngles.variances_at`."""
        ahead = 1e-9 * (stamp_ns - self._stamps[-1])
        if ahead <= 0.0:
            return sigma**2
        begin = self._begin(len(self._stamps) - 1)
        if begin is None:
            return sigma**2 + (UNKNOWN_RATE_RAD_S * ahead) ** 2
        interval = 1e-9 * (self._stamps[-1] - self._stamps[begin])
        share = ahead / interval
        strayed = 0.5 * acceleration * ahead * (ahead + interval)
        return sigma**2 * ((1.0 + share) ** 2 + share**2) + strayed**2

    def _begin(self, end: int) -> int | None:
        """Return the sample from which to one the rate is taken; None if there is none."""
        stamps = self._stamps
        begin = bisect_right(stamps, stamps[end] - SPAN_NS) - 1
        return begin if begin >= 0 and stamps[end] - stamps[begin] <= self._hold_ns else None

    def _rate(self, begin: int, end: int) -> float:
        """Return the rate from one sample to another, rad/s."""
        seconds = 1e-9 * (self._stamps[end] - self._stamps[begin])
        # The short way round: a joint that turns for ever may be read modulo a turn.
        return remainder(self._angles[end] - self._angles[begin], tau) / seconds

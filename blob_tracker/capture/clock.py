"""Kernel stamps (CLOCK_MONOTONIC) -> ROS time (CLOCK_REALTIME), in ns."""

from __future__ import annotations

from collections.abc import Callable
import time

# What slews the real-time clock slews the monotonic one with it (clock_gettime(2)). Their distance
# changes by steps alone: when the clock is set (chronyc makestep, phc2sys; by any amount), at a
# leap second, and while the machine is suspended.
STEP_NS = 1_000_000
STEP_BRACKETS = 4  # a reading is wrong by half its bracket at most; so is the one before
MAX_SLEW = 500e-6
FAR_AHEAD_NS = 60_000_000_000


class RealtimeClock:
    """
    Turns stamps of the monotonic clock into real time; they jump only if that clock was set.

    offset = realtime - (monotonic before + monotonic after) / 2 is read several times and the
    tightest reading is kept: it is wrong by half its bracket at most. An offset that differs from
    the one in use by more than STEP_NS and by STEP_BRACKETS brackets is a step of the real-time
    clock: the stamps step with it at once, as ROS time does for every other node. The offset in
    use follows anything less at MAX_SLEW at most, so that a reading spoilt by a busy machine,
    whose bracket is wide, moves a stamp by less than 8.4 us at 60 frames/s and stamps keep their
    order.

    Parameters
    ----------
    monotonic, realtime : function
        Return the clocks' times, ns.

    """

    def __init__(
        self,
        monotonic: Callable[[], int] = time.monotonic_ns,
        realtime: Callable[[], int] = time.time_ns,
    ) -> None:
        self._monotonic = monotonic
        self._realtime = realtime
        self._measured_at, self._offset, _ = self._measure()

    def from_monotonic(self, monotonic_ns: int) -> int:
        """Return the real time, ns, of an instant of the monotonic clock, ns."""
        measured_at, offset, bracket = self._measure()
        error = offset - self._offset
        if abs(error) <= max(STEP_NS, STEP_BRACKETS * bracket):
            most = round(MAX_SLEW * (measured_at - self._measured_at))
            error = max(-most, min(most, error))
        self._offset += error
        self._measured_at = measured_at
        return monotonic_ns + self._offset

    def monotonic(self, stamp_ns: int) -> int:
        """
        Return a driver's stamp, ns, in monotonic time.

        With its option `clock=CLOCK_REALTIME` uvcvideo stamps in real time, and its buffers say
        monotonic all the same. Such a stamp is years ahead.
        """
        ahead_ns = stamp_ns - self._monotonic()
        return stamp_ns if ahead_ns < FAR_AHEAD_NS else stamp_ns - self._offset

    def _measure(self, readings: int = 5) -> tuple[int, int, int]:
        """Return the tightest of several readings: (monotonic time, offset, bracket), ns."""
        tightest = None
        for _ in range(readings):
            before = self._monotonic()
            realtime = self._realtime()
            after = self._monotonic()
            if tightest is None or after - before < tightest[2]:
                middle = (before + after) // 2
                tightest = (middle, realtime - middle, after - before)
        assert tightest is not None
        return tightest

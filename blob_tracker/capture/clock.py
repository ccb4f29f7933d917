"""Kernel stamps (CLOCK_MONOTONIC) -> ROS time (CLOCK_REALTIME), in ns."""

from __future__ import annotations

from collections.abc import Callable
import time

# The kernel slews its clock by at most 500 ppm (adjtimex(2)); faster than that the distance of
# the two clocks never changes, except by a step. Steps are made beyond 128 ms (ntpd's limit).
MAX_SLEW = 500e-6
STEP_NS = 128_000_000


class RealtimeClock:
    """
    Turns stamps of the monotonic clock into real time without ever jumping.

    offset = realtime - (monotonic before + monotonic after) / 2 is read several times and the
    tightest reading is kept: it is wrong by half its bracket at most. The offset in use follows
    at MAX_SLEW at most, so that a reading spoilt by a busy machine moves a stamp by less than
    8 us at 60 frames/s and stamps keep their order. Only where the real-time clock itself was
    set by more than STEP_NS do the stamps step with it, as ROS time does for every other node.

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
        self._measured_at, self._offset = self._measure()

    def from_monotonic(self, monotonic_ns: int) -> int:
        """Return the real time, ns, of an instant of the monotonic clock, ns."""
        measured_at, offset = self._measure()
        error = offset - self._offset
        if abs(error) < STEP_NS:
            most = round(MAX_SLEW * (measured_at - self._measured_at))
            error = max(-most, min(most, error))
        self._offset += error
        self._measured_at = measured_at
        return monotonic_ns + self._offset

    def _measure(self, readings: int = 5) -> tuple[int, int]:
        """Return the tightest of several readings: (monotonic time, offset), ns."""
        tightest = None
        for _ in range(readings):
            before = self._monotonic()
            realtime = self._realtime()
            after = self._monotonic()
            if tightest is None or after - before < tightest[0]:
                middle = (before + after) // 2
                tightest = (after - before, middle, realtime - middle)
        assert tightest is not None
        return tightest[1], tightest[2]

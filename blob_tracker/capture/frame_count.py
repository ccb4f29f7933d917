"""Frames that were lost between those that came, by the driver's numbers or by its stamps."""

from __future__ import annotations

from collections import deque
import statistics

# Of the intervals whose median is that of frames: fewer tell little, more are slow to follow a
# camera that takes longer in the dark.
FEWEST, MOST = 5, 15
LATE = 0.6  # of an interval, by which the stamp of a frame may be late


class FrameCount:
    """
    How many frames were lost, and how long a frame takes.

    A driver numbers the frames, and a hole is what was lost. `uvcvideo` counts what the camera
    begins to send: it knows nothing of a frame that is lost on the bus, and counts one twice whose
    end the camera does not mark. There the stamps tell: of frames dt apart, of which half are no
    more than T apart, floor(dt / T + 1 - LATE) - 1 were lost between.

    Parameters
    ----------
    numbered : bool
        Whether the driver's numbers are those of the frames.

    Attributes
    ----------
    lost : int
        Frames between those that came.
    interval_ns : int
        From frame to frame; 0 where it is not yet known.

    """

    lost = 0
    interval_ns = 0

    def __init__(self, numbered: bool) -> None:
        self._numbered = numbered
        self._first = self._last = (-1, 0)  # number and stamp
        self._intervals: deque[int] = deque(maxlen=MOST)

    def came(self, number: int, stamp_ns: int) -> None:
        """Take note of a frame, of the driver's number of 32 bits and its stamp."""
        step = (number - self._last[0]) & 0xffffffff
        since_ns = stamp_ns - self._last[1]
        if self._last[0] < 0 or not 0 < step < 0x80000000:
            # The first frame, or a driver that starts its count again.
            self._first = (number, stamp_ns)
            self._intervals.clear()
        elif self._numbered:
            self.lost += step - 1
            begin, begin_ns = self._first
            # The mean, as the stamps of single frames jitter on a busy machine.
            self.interval_ns = (stamp_ns - begin_ns) // ((number - begin) & 0xffffffff)
        else:
            self._intervals.append(since_ns)
            if len(self._intervals) >= FEWEST:
                self.interval_ns = round(statistics.median(self._intervals))
                self.lost += max(0, int(since_ns / max(1, self.interval_ns) + 1 - LATE) - 1)
        self._last = (number, stamp_ns)

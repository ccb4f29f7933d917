"""Frames that were lost between those that came, by the driver's numbers or by its stamps."""

from __future__ import annotations

from collections import deque
import statistics

from blob_tracker.capture.frame_rate import MeasuredRate

# Of the intervals whose median is that of frames: fewer tell little, more are slow to follow a
# camera that takes longer in the dark.
FEWEST, MOST = 5, 15
# A busy machine stamps a frame late, and the next ones make up for it: what is missing after so
# many is lost. Of an interval, how late they may all be; and the part of that which is taken for
# the error of the interval.
PATIENCE, LATE, GIVEN_IN = 5, 0.6, 0.2


class FrameCount:
    """
    How many frames were lost, and how long a frame takes.

    A driver numbers the frames, and a hole is what was lost. `uvcvideo` counts what the camera
    begins to send: it knows nothing of a frame that is lost on the bus, and counts one twice whose
    end the camera does not mark. There the stamps tell, PATIENCE frames later: each is dt / T - 1
    later than the one before would have it, where half of the intervals are no more than T.

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
        self._came = 0
        self._measured = MeasuredRate()
        self._first = self._last = (-1, 0)  # number and stamp
        self._intervals: deque[int] = deque(maxlen=MOST)
        self._late: deque[float] = deque([0.0], maxlen=PATIENCE)  # intervals

    @property
    def rate(self) -> float:
        """Return the frames/s, those that were lost too; 0 while that is unknown."""
        return self._measured.rate

    def came(self, number: int, stamp_ns: int) -> None:
        """Take note of a frame, of the driver's number of 32 bits and its stamp."""
        step = (number - self._last[0]) & 0xffffffff
        since_ns = stamp_ns - self._last[1]
        if self._last[0] < 0 or not 0 < step < 0x80000000:
            # The first frame, or a driver that starts its count again.
            self._first = (number, stamp_ns)
            self._intervals.clear()
            self._late = deque([0.0], maxlen=PATIENCE)
        elif self._numbered:
            self.lost += step - 1
            begin, begin_ns = self._first
            # The mean, as the stamps of single frames jitter on a busy machine.
            self.interval_ns = (stamp_ns - begin_ns) // ((number - begin) & 0xffffffff)
        else:
            self._intervals.append(since_ns)
            if len(self._intervals) >= FEWEST:
                self.interval_ns = round(statistics.median(self._intervals))
                self._late.append(self._late[-1] + since_ns / max(1, self.interval_ns) - 1.0)
                self._judge()
        self._last = (number, stamp_ns)
        self._came += 1
        self._measured.add(self._came + self.lost, stamp_ns)

    def _judge(self) -> None:
        """Count what all of the last frames are late by."""
        if len(self._late) < PATIENCE:
            return
        least = min(self._late)
        lost = int(least + LATE) if least > LATE else 0
        self.lost += lost
        taken = lost or GIVEN_IN * least
        self._late = deque((late - taken for late in self._late), maxlen=PATIENCE)

"""Messages that did not come, by the gaps between the stamps of those that did."""

from __future__ import annotations

from collections import deque

LAST = 300  # messages over which a loss is a share
GRAVE, SEVERAL = 0.01, 3  # share and count of those lost from which on it is worth a word
RECENT = 15  # intervals, an odd number, of which the usual one is the median
GAP = 1.5  # usual intervals from which on one is missing
PAUSE = 30.0  # usual intervals from which on it is a pause and no loss


def grave(lost: int, taken: int) -> bool:
    """Tell whether so many messages were lost, beside those taken, that it is worth a word."""
    return lost >= SEVERAL and lost > GRAVE * (lost + taken)


class Losses:
    """Messages that were lost: all of them, and their share of the last three hundred."""

    def __init__(self) -> None:
        self.total = 0
        self._last: deque[int] = deque(maxlen=LAST)

    def add(self, lost: int) -> None:
        """Take a message, and how many were lost before it."""
        self.total += lost
        self._last.append(lost)

    @property
    def share(self) -> float:
        """Part of the last messages that was lost."""
        lost = sum(self._last)
        return lost / max(lost + len(self._last), 1)

    @property
    def grave(self) -> bool:
        """Tell whether so many were lost of late that it is worth a word."""
        return grave(sum(self._last), len(self._last))


class StampGaps:
    """
    Count what is missing between the stamps of a steady stream.

    A stream of which every other message is lost is one of half the rate: that nobody can tell.
    """

    def __init__(self) -> None:
        self._previous: int | None = None
        self._intervals: deque[int] = deque(maxlen=RECENT)

    def missing(self, stamp_ns: int) -> int:
        """
        Return how many messages are missing between the previous stamp and this one.

        Parameters
        ----------
        stamp_ns : int
            ns.

        Returns
        -------
        int
            0 while the usual interval is not known, after a pause of 30 intervals, and where the
            stamps go back.

        """
        previous, self._previous = self._previous, stamp_ns
        if previous is None or stamp_ns <= previous:
            return 0
        interval = stamp_ns - previous
        known = len(self._intervals) == RECENT
        if known and interval <= GAP * min(self._intervals):  # most often, and sooner told
            self._intervals.append(interval)
            return 0
        usual = sorted(self._intervals)[RECENT // 2] if known else interval  # their median
        self._intervals.append(interval)
        return round(interval / usual) - 1 if GAP < interval / usual < PAUSE else 0

"""Sights of two cameras that see at different instants -> pairs of one instant."""

from __future__ import annotations

from collections import deque

from blob_tracker.tracking.sight import between, Sight

MOST = 256  # sights that wait; a second of the fastest camera


class Simultaneous:
    """
    Bring the sights of a second camera to the instants of a first one.

    Each sight of the first camera that lies between two of the second gives a pair, with the
    second's interpolated. So it waits for the next one of the second camera: half an interval of
    it on average, none at all where the stamps are equal, as of cameras with one trigger. The
    pairs depend on the stamps alone, not on the order in which the cameras' sights arrive.

    Parameters
    ----------
    max_interval : float
        Greatest time between the two sights of the second camera, s.
    acceleration : float
        How the light moves between them, mrad/s^2, see `interpolated`.

    Attributes
    ----------
    skipped : int
        Sights of the first camera that had none of the second near enough.
    interval : float
        Time between the two sights of the second camera about the last of the first one that
        was paired or skipped, s; NaN before.

    """

    def __init__(self, max_interval: float, acceleration: float) -> None:
        self.max_interval = max_interval
        self.acceleration = acceleration
        self.skipped = 0
        self.interval = float('nan')
        self._first: deque[Sight] = deque(maxlen=MOST)
        self._second: deque[Sight] = deque(maxlen=MOST)

    def first(self, sight: Sight) -> list[tuple[Sight, Sight]]:
        """
        Take the next sight of the first camera; return the pairs that it completes.

        Raises
        ------
        ValueError
            Where its stamp is not later than the last one: it is left out, or, where the stamps
            jumped back by more than `max_interval`, all that waits is.

        """
        self._take(self._first, sight)
        return self._pairs()

    def second(self, sight: Sight) -> list[tuple[Sight, Sight]]:
        """Take the next sight of the second camera; else as `first`."""
        self._take(self._second, sight)
        return self._pairs()

    def forget(self, after_ns: int) -> None:
        """Give up what has a later stamp, ns."""
        for waiting in (self._first, self._second):
            while waiting and waiting[-1].stamp_ns > after_ns:
                waiting.pop()

    def _take(self, waiting: deque[Sight], sight: Sight) -> None:
        """Let a sight wait."""
        if waiting:
            late = 1e-9 * (waiting[-1].stamp_ns - sight.stamp_ns)
            if late > self.max_interval:
                self.forget(-1)
                waiting.append(sight)
                raise ValueError(f'the stamps jumped back by {late:.3f} s; starting afresh')
            if late >= 0.0:
                raise ValueError(
                    f'ray left out: its stamp is {late:.3f} s older than the one before or the '
                    'same; stamps must grow'
                )
        waiting.append(sight)

    def _pairs(self) -> list[tuple[Sight, Sight]]:
        """Return the pairs of which both ends are there."""
        pairs = []
        while self._first and self._second and self._second[-1].stamp_ns >= (
            self._first[0].stamp_ns
        ):
            seen = self._first.popleft()
            while len(self._second) > 1 and self._second[1].stamp_ns <= seen.stamp_ns:
                self._second.popleft()
            before = self._second[0]
            if before.stamp_ns == seen.stamp_ns:
                self.interval = 0.0
                pairs.append((seen, before))
                continue
            # The only one is later: there was none before.
            after = self._second[1] if len(self._second) > 1 else before
            self.interval = 1e-9 * (after.stamp_ns - min(before.stamp_ns, seen.stamp_ns))
            if before.stamp_ns > seen.stamp_ns or self.interval > self.max_interval:
                self.skipped += 1
                continue
            pairs.append((seen, between(before, after, seen.stamp_ns, self.acceleration)))
        return pairs

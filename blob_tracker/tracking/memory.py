"""The bearings of the last second: where one that is late is put in its place."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from typing import NamedTuple

from blob_tracker.tracking.errors import StampJump, TrackingError
from blob_tracker.tracking.hypothesis import Situation
from blob_tracker.tracking.kalman import Measurement

MEMORY_NS = 1_000_000_000  # for which late bearings are put in their place: a message's delay


class Entry(NamedTuple):
    """A bearing, and what it left behind."""

    measurement: Measurement
    stamp_ns: int
    after: Situation


class Memory:
    """
    Apply bearings in the order of their stamps, in whatever order they come.

    After one that is late, those with later stamps are applied again: the situation is that of
    the right order, bit for bit.

    Parameters
    ----------
    follow : callable
        Returns the situation after a bearing from the one before, the measurement and its stamp.

    """

    def __init__(self, follow: Callable[[Situation, Measurement, int], Situation]) -> None:
        self._follow = follow
        self._before = Situation()  # what the oldest entry was applied to
        self._entries: list[Entry] = []
        self._stamps: list[int] = []

    def clear(self) -> None:
        """Forget all bearings."""
        self._before = Situation()
        self._entries.clear()
        self._stamps.clear()

    @property
    def newest(self) -> Situation:
        """Return what all bearings leave behind."""
        return self._entries[-1].after if self._entries else self._before

    @property
    def oldest_ns(self) -> int | None:
        """Stamp of the oldest bearing that is kept, ns; None if there is none."""
        return self._stamps[0] if self._stamps else None

    def until(self, stamp_ns: int) -> Situation:
        """Return what the bearings until an instant leave behind."""
        place = bisect_right(self._stamps, stamp_ns)
        return self._entries[place - 1].after if place else self._before

    def place(self, stamp_ns: int) -> int:
        """
        Return the place of a new bearing, counted from the oldest.

        Raises
        ------
        TrackingError
            If there is a bearing with this stamp.
        StampJump
            If the stamp is from before the memory.

        """
        stamps = self._stamps
        if not stamps or stamp_ns > stamps[-1]:
            return len(stamps)
        late = stamps[-1] - stamp_ns
        if late > MEMORY_NS:
            raise StampJump(
                f'the stamp is {1e-9 * late:.3f} s before the newest one; a bearing can be '
                f'{1e-9 * MEMORY_NS:g} s late (was the clock set back?)'
            )
        place = bisect_left(stamps, stamp_ns)
        if stamps[place] == stamp_ns:
            raise TrackingError(f'there is a bearing with the stamp {stamp_ns} ns')
        return place

    def insert(
        self, place: int, measurement: Measurement, stamp_ns: int
    ) -> tuple[Situation, bool]:
        """
        Apply a bearing at its place, and again those after it.

        Returns
        -------
        Situation, bool
            What it leaves behind, and whether it is late.

        """
        late = place < len(self._entries)
        before = self._entries[place - 1].after if place else self._before
        mine = self._follow(before, measurement, stamp_ns)
        self._stamps.insert(place, stamp_ns)
        self._entries.insert(place, Entry(measurement, stamp_ns, mine))
        before = mine
        for index in range(place + 1, len(self._entries)):
            entry = self._entries[index]
            before = self._follow(before, entry.measurement, entry.stamp_ns)
            self._entries[index] = entry._replace(after=before)
        self._forget()
        return mine, late

    def _forget(self) -> None:
        """Drop the bearings before which no late one can come."""
        count = bisect_left(self._stamps, self._stamps[-1] - MEMORY_NS)
        if count:
            self._before = self._entries[count - 1].after
            del self._entries[:count], self._stamps[:count]

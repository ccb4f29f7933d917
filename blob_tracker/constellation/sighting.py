"""Bearings of a body's lights as they come -> those of one sighting."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.constellation.errors import ConstellationError
from blob_tracker.types import Bearing

NS = 1e-9  # s


class Sighting:
    """
    Collect bearings until each light of a body has one, or an interval is over.

    Of each light the last bearing counts, and each counts once: poses of one sighting and the next
    have errors of their own. A light that is hidden is waited for until a bearing of another comes
    whose stamp is more than the interval after the first.

    Parameters
    ----------
    names : sequence of str
        The lights of the body.
    max_interval : float
        Greatest time between two bearings of one sighting, s.

    """

    def __init__(self, names: Sequence[str], max_interval: float) -> None:
        self.max_interval = max_interval
        self._names = tuple(names)
        self._bearings: dict[str, Bearing] = {}
        self._first_ns = 0  # of all that came, also where a later one of that light counts

    def take(self, name: str, bearing: Bearing) -> list[tuple[str, Bearing]]:
        """
        Take the next bearing of a light; return those of the sighting that it completes or ends.

        They are in the order of the body's lights; none while more are waited for.

        Raises
        ------
        ConstellationError
            Where its stamp is not later than the last one of that light: it is left out, or,
            where the stamps jumped back by more than `max_interval`, all others are.

        """
        stamps = [each.stamp_ns for each in self._bearings.values()]
        late = NS * (max(stamps, default=bearing.stamp_ns) - bearing.stamp_ns)
        if late > self.max_interval:
            self._bearings, self._first_ns = {name: bearing}, bearing.stamp_ns
            raise ConstellationError(f'the stamps jumped back by {late:.3f} s; starting afresh')
        before = self._bearings.get(name)
        if before is not None and bearing.stamp_ns <= before.stamp_ns:
            raise ConstellationError(
                'a ray has the stamp of the one before it, or an earlier one; it is left out'
            )
        ended: list[tuple[str, Bearing]] = []
        if stamps and NS * (bearing.stamp_ns - self._first_ns) > self.max_interval:
            ended = self._end()
        if not self._bearings:
            self._first_ns = bearing.stamp_ns
        self._first_ns = min(self._first_ns, bearing.stamp_ns)
        self._bearings[name] = bearing
        if len(self._bearings) < len(self._names):
            return ended
        return self._end()

    def forget(self, after_ns: int) -> None:
        """Give up what has a later stamp, ns."""
        self._bearings = {
            name: each for name, each in self._bearings.items() if each.stamp_ns <= after_ns
        }

    def _end(self) -> list[tuple[str, Bearing]]:
        """Return the bearings of this sighting, and begin the next."""
        found = [(name, self._bearings[name]) for name in self._names if name in self._bearings]
        self._bearings = {}
        return found

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
    whose stamp is more than the interval after the first. One whose bearings come later than that
    after those of the others is not waited for.

    Parameters
    ----------
    names : sequence of str
        The lights of the body.
    max_interval : float
        Greatest time between two bearings of one sighting, s.

    Examples
    --------
    Three lights that are seen one after the other:

    >>> import numpy as np
    >>> sighting = Sighting(('port', 'starboard', 'mast'), max_interval=0.1)
    >>> for ms, name in ((0, 'starboard'), (5, 'port'), (10, 'mast')):
    ...     seen = sighting.take(name, Bearing(0.0, 0.0, np.eye(2), 1_000_000 * ms))
    ...     print([light for light, _ in seen])
    []
    []
    ['port', 'starboard', 'mast']

    """

    def __init__(self, names: Sequence[str], max_interval: float) -> None:
        self.max_interval = max_interval
        self._names = tuple(names)
        self._bearings: dict[str, Bearing] = {}
        self._last_ns: dict[str, int] = {}  # of each light
        self._late_ns: dict[str, int] = {}  # first that came too late, since any was in time
        self._first_ns = 0  # of all that came, also where a later one of that light counts

    def take(self, name: str, bearing: Bearing) -> list[tuple[str, Bearing]]:
        """
        Take the next bearing of a light; return those of the sighting that it completes or ends.

        They are in the order of the body's lights; none while more are waited for.

        Raises
        ------
        ConstellationError
            If its stamp is not later than the last one of that light, or more than
            `max_interval` before that of another: it is left out. Where the stamps of that light
            jumped back by more than `max_interval`, all others are.

        """
        newest_ns = max(self._last_ns.values(), default=bearing.stamp_ns)
        before_ns = self._last_ns.get(name, bearing.stamp_ns - 1)
        late = NS * (newest_ns - bearing.stamp_ns)
        # Too late for an interval with none in time: the newest stamp was wrong, or all jumped.
        late_ns = bearing.stamp_ns - self._late_ns.get(name, bearing.stamp_ns)
        if NS * (before_ns - bearing.stamp_ns) > self.max_interval or (
                late > self.max_interval and NS * late_ns > self.max_interval):
            self._bearings, self._first_ns = {name: bearing}, bearing.stamp_ns
            self._last_ns, self._late_ns = {name: bearing.stamp_ns}, {}
            raise ConstellationError(f'the stamps jumped back by {late:.3f} s; starting again')
        if bearing.stamp_ns <= before_ns:
            raise ConstellationError(
                'a ray has the stamp of the one before it, or an earlier one; it is left out'
            )
        self._last_ns[name] = bearing.stamp_ns
        if late > self.max_interval:
            self._late_ns.setdefault(name, bearing.stamp_ns)
            raise ConstellationError(
                f'its rays come {late:.3f} s later than those of other lights, and more than '
                'max_interval: it is left out'
            )
        self._late_ns.clear()
        ended: list[tuple[str, Bearing]] = []
        if self._bearings and NS * (bearing.stamp_ns - self._first_ns) > self.max_interval:
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
        self._last_ns = {
            name: stamp_ns for name, stamp_ns in self._last_ns.items() if stamp_ns <= after_ns
        }

    def _end(self) -> list[tuple[str, Bearing]]:
        """Return the bearings of this sighting, and begin the next."""
        found = [(name, self._bearings[name]) for name in self._names if name in self._bearings]
        self._bearings = {}
        return found

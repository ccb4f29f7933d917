"""Bearings of a body's lights as they come -> those of one sighting."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from blob_tracker.constellation.errors import ConstellationError
from blob_tracker.types import Bearing

NS = 1e-9  # s
REMEMBERED = 12  # stamps, by which lights in step are told from coded ones
IN_STEP = 0.85  # of the lights at each stamp: a code is lit for two bits of three, rarely more


class Sighting:
    """
    Collect bearings until each light of a body has one, or an interval is over.

    Of each light the last bearing counts, and each counts once: poses of one sighting and the next
    have errors of their own. A light that is hidden is waited for until a bearing of another comes
    whose stamp is more than the interval after the first. One whose bearings come later than that
    after those of the others is not waited for.

    Lights that are all on or off together share one stamp in each frame. One of them may be missed
    in a frame, and messages of one topic may overtake those of another: so a sighting of such
    lights is of one stamp, that of all of them, or at the end of the interval of most. Twelve
    stamps tell that lights are such ones.

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
        self._bearings: dict[str, dict[int, Bearing]] = {}  # of each light, by its stamp
        self._last_ns: dict[str, int] = {}  # of each light
        self._late_ns: dict[str, int] = {}  # first that came too late, since any was in time
        self._first_ns = 0  # of all that came, also where a later one of that light counts
        self._seen: dict[int, set[str]] = {}  # the lights of the last stamps

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
            self._bearings, self._first_ns = {}, bearing.stamp_ns
            self._last_ns, self._late_ns, self._seen = {}, {}, {}
            self._add(name, bearing)
            raise ConstellationError(f'the stamps jumped back by {late:.3f} s; starting again')
        if bearing.stamp_ns <= before_ns:
            raise ConstellationError(
                'a ray has the stamp of the one before it, or an earlier one; it is left out'
            )
        if late > self.max_interval:
            self._last_ns[name] = bearing.stamp_ns
            self._late_ns.setdefault(name, bearing.stamp_ns)
            raise ConstellationError(
                f'its rays come {late:.3f} s later than those of other lights, and more than '
                'max_interval: it is left out'
            )
        self._late_ns.clear()
        ended: list[tuple[str, Bearing]] = []
        if self._bearings and NS * (bearing.stamp_ns - self._first_ns) > self.max_interval:
            ended = self._end()
        self._add(name, bearing)
        if len(self._bearings) < len(self._names):
            return ended
        if self._are_in_step() and len(self._at(bearing.stamp_ns)) < len(self._names):
            return ended
        return self._end()

    def forget(self, after_ns: int) -> None:
        """Give up what has a later stamp, ns."""
        self._keep(lambda stamp_ns: stamp_ns <= after_ns)
        self._last_ns = {
            name: stamp_ns for name, stamp_ns in self._last_ns.items() if stamp_ns <= after_ns
        }
        self._seen = {
            stamp_ns: names for stamp_ns, names in self._seen.items() if stamp_ns <= after_ns
        }

    def _add(self, name: str, bearing: Bearing) -> None:
        """Add a bearing that is in time, and remember its stamp."""
        stamp_ns = bearing.stamp_ns
        self._first_ns = min(self._first_ns, stamp_ns) if self._bearings else stamp_ns
        self._bearings.setdefault(name, {})[stamp_ns] = bearing
        self._last_ns[name] = stamp_ns
        self._seen.setdefault(stamp_ns, set()).add(name)
        if len(self._seen) > REMEMBERED:
            del self._seen[min(self._seen)]

    def _are_in_step(self) -> bool:
        """Tell whether the stamps before the last, whose bearings still come, have all lights."""
        if len(self._seen) < REMEMBERED:
            return False
        shown = [self._seen[stamp_ns] for stamp_ns in sorted(self._seen)[:-1]]
        lights: set[str] = set().union(*shown)
        return sum(map(len, shown)) > IN_STEP * len(shown) * len(lights)

    def _at(self, stamp_ns: int) -> dict[str, Bearing]:
        """Return the bearings of one stamp."""
        return {
            name: each[stamp_ns] for name, each in self._bearings.items() if stamp_ns in each
        }

    def _end(self) -> list[tuple[str, Bearing]]:
        """Return the bearings of this sighting, and begin the next."""
        if self._are_in_step():
            stamps_ns = {stamp_ns for each in self._bearings.values() for stamp_ns in each}
            ended_ns = max(stamps_ns, key=lambda each_ns: (len(self._at(each_ns)), each_ns))
            used = self._at(ended_ns)
        else:
            used = {name: each[max(each)] for name, each in self._bearings.items()}
            ended_ns = max(bearing.stamp_ns for bearing in used.values())
        self._keep(lambda stamp_ns: stamp_ns > ended_ns)  # overtook the others
        return [(name, used[name]) for name in self._names if name in used]

    def _keep(self, wanted: Callable[[int], bool]) -> None:
        """Keep the bearings of these stamps alone."""
        self._bearings = {
            name: kept for name, each in self._bearings.items()
            if (kept := {stamp_ns: one for stamp_ns, one in each.items() if wanted(stamp_ns)})
        }
        self._first_ns = min(
            (min(each) for each in self._bearings.values()), default=self._first_ns)

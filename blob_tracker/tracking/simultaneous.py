"""Sights of several cameras that see at different instants -> those of one instant."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.interpolation import strays
from blob_tracker.tracking.sight import between, Sight
from blob_tracker.units import MRAD
import numpy as np

MOST = 256  # sights that wait; a second of the fastest camera
NEVER_NS = -1


class Instant(NamedTuple):
    """
    What cameras see at one instant.

    Parameters
    ----------
    cameras : tuple of int
        Their places in the row, two or more; the stamp is that of a bearing of the first.
    sights : tuple of Sight
        Of each.
    strayed : (n, n) array
        Covariance of what the light may have strayed from the lines on which bearings were
        interpolated, seen across each ray, rad^2; see `strays`.

    Examples
    --------
    What goes to `triangulate`:

    >>> from blob_tracker.tracking import CameraPose, triangulate
    >>> from blob_tracker.types import Bearing
    >>> sights = tuple(
    ...     Sight(Bearing(azimuth, 0.0, 0.01 * np.eye(2)), CameraPose(np.array([x, 0.0, 0.0])))
    ...     for azimuth, x in ((50.0, 0.0), (-50.0, 1.0))
    ... )
    >>> instant = Instant((0, 1), sights, strayed=np.zeros((2, 2)))
    >>> light = triangulate(*zip(*instant.sights), strayed=instant.strayed)
    >>> light.position[::2].round(2).tolist()  # x and z, m
    [0.5, 9.99]

    """

    cameras: tuple[int, ...]
    sights: tuple[Sight, ...]
    strayed: Array


class Simultaneous:
    """
    Bring the sights of cameras to the instants of the first one of them that sees the light.

    A camera sees the light at an instant if it has a bearing of it, or one before and one after
    that are no further apart than `max_interval`. The stamps of the first camera in the row that
    does so stand, and the bearings of the later ones are interpolated to them. So what is given
    waits for the next bearing of each: half an interval on average, none at all where the stamps
    are equal, as of cameras with one trigger.

    What is given depends on the stamps alone, not on the order in which the cameras' sights
    arrive, as long as no camera's come more than `max_interval` later than those of two others:
    so long is one that is silent waited for, and longer if a single one is left without it. A
    single camera whose stamps are ahead makes no other one late.

    Parameters
    ----------
    cameras : int
        How many there are.
    max_interval : float
        Greatest time between two bearings that are interpolated, s.
    acceleration : float
        How the light moves between them: standard deviation of the change of its angular rate in
        one second, mrad/s^2.

    Attributes
    ----------
    skipped : int
        Bearings to whose instants no other camera had any near enough, before and after.
    gap : float
        Time between the two nearest about the last of them, s: more than `max_interval`. NaN
        before.
    unseen : int
        Bearings to whose instants all others had none before, as they began later, or none after.
    late : list of int
        Of each camera, bearings that came when what there was of their instant had been given.
    interval : float
        Longest time between two bearings that were interpolated last, s; NaN before.

    Examples
    --------
    A light that goes by 1 mrad/ms, and a second camera that is 5 ms later than the first; what it
    sees is interpolated to the first one's stamp:

    >>> from blob_tracker.types import Bearing
    >>> from blob_tracker.tracking import CameraPose
    >>> pairing = Simultaneous(2, max_interval=0.1, acceleration=0.0)
    >>> for ms, camera in ((0, 0), (5, 1), (20, 0), (25, 1)):
    ...     bearing = Bearing(1.0 * ms, 0.0, 0.01 * np.eye(2), 1_000_000 * ms)
    ...     for instant in pairing.take(camera, Sight(bearing, CameraPose(np.zeros(3)))):
    ...         print(instant.cameras, [sight.bearing.azimuth for sight in instant.sights])  # mrad
    (0, 1) [20.0, 20.0]

    """

    def __init__(self, cameras: int, max_interval: float, acceleration: float) -> None:
        self.max_interval = max_interval
        self.acceleration = acceleration
        self.skipped = self.unseen = 0
        self.gap = float('nan')
        self.late = [0] * cameras
        self.interval = float('nan')
        self._done_ns = NEVER_NS  # what came of the instants up to it is given
        self._seen: list[deque[Sight]] = [deque(maxlen=MOST) for _ in range(cameras)]
        # Those that may give an instant: of all but the last camera.
        self._waiting: list[deque[Sight]] = [deque(maxlen=MOST) for _ in range(cameras - 1)]

    def take(self, camera: int, sight: Sight) -> list[Instant]:
        """
        Take the next sight of a camera; return what it completes.

        Parameters
        ----------
        camera : int
            Its place in the row.
        sight : Sight
            What it has seen.

        Returns
        -------
        list of Instant
            In the order of their stamps.

        Raises
        ------
        ValueError
            If its stamp is not later than the last one: it is left out, or, where the stamps
            jumped back by more than `max_interval`, all that waits is.

        """
        seen = self._seen[camera]
        jump = ''
        if seen:
            late = 1e-9 * (seen[-1].stamp_ns - sight.stamp_ns)
            if late > self.max_interval:
                self.forget(NEVER_NS)
                jump = f'the stamps jumped back by {late:.3f} s; starting again'
            elif late >= 0.0:
                raise ValueError(
                    f'ray left out: its stamp is {late:.3f} s older than the one before or the '
                    'same; stamps must grow'
                )
        seen.append(sight)
        if sight.stamp_ns <= self._done_ns:
            self.late[camera] += 1
        elif camera < len(self._waiting):
            self._waiting[camera].append(sight)
        if jump:
            raise ValueError(jump)
        return self._complete()

    def forget(self, after_ns: int) -> None:
        """Give up what has a later stamp, ns."""
        self._done_ns = min(self._done_ns, after_ns)
        for sights in (*self._seen, *self._waiting):
            while sights and sights[-1].stamp_ns > after_ns:
                sights.pop()

    def leave_out(self, camera: int) -> None:
        """Give up all that came of a camera."""
        self._seen[camera].clear()
        if camera < len(self._waiting):
            self._waiting[camera].clear()

    def _complete(self) -> list[Instant]:
        """Return what is there of all cameras."""
        complete = []
        while any(self._waiting):
            # The earliest; of equal stamps that of the first camera.
            camera = min(
                (each for each, waiting in enumerate(self._waiting) if waiting),
                key=lambda each: self._waiting[each][0].stamp_ns,
            )
            sight = self._waiting[camera][0]
            around = self._around(sight.stamp_ns)
            if around is None or self._alone(camera, sight.stamp_ns):
                break
            self._waiting[camera].popleft()
            self._done_ns = sight.stamp_ns
            if not any(around[:camera]):
                if any(around[camera + 1:]):
                    complete.append(self._brought(around, sight.stamp_ns))
                else:
                    self._skip(sight.stamp_ns)
            for seen in self._seen:
                while len(seen) > 1 and seen[1].stamp_ns <= sight.stamp_ns:
                    seen.popleft()
        return complete

    def _around(self, stamp_ns: int) -> list[tuple[Sight, Sight] | None] | None:
        """Return each camera's sights about an instant, or None while one may still come."""
        # Of the second camera: the clock of the first may be ahead of all others.
        newest_ns = sorted(seen[-1].stamp_ns for seen in self._seen if seen)[-2:][0]
        around: list[tuple[Sight, Sight] | None] = []
        for seen in self._seen:
            if seen and seen[-1].stamp_ns < stamp_ns and (
                1e-9 * (newest_ns - seen[-1].stamp_ns) <= self.max_interval
            ):
                return None
            pair = _about(seen, stamp_ns)
            around.append(pair if pair and _apart(*pair) <= self.max_interval else None)
        return around

    def _alone(self, camera: int, stamp_ns: int) -> bool:
        """Tell whether no other camera has come so far."""
        return not any(
            seen and seen[-1].stamp_ns >= stamp_ns
            for number, seen in enumerate(self._seen) if number != camera
        )

    def _skip(self, stamp_ns: int) -> None:
        """Count an instant that a single camera has seen."""
        pairs = [_about(seen, stamp_ns) for seen in self._seen]
        gaps = [_apart(*pair) for pair in pairs if pair and pair[0] is not pair[1]]
        if gaps:
            self.skipped += 1
            self.gap = min(gaps)
        else:
            self.unseen += 1

    def _brought(
        self, around: list[tuple[Sight, Sight] | None], stamp_ns: int
    ) -> Instant:
        """Return what all that see the light see at an instant."""
        pairs = {number: pair for number, pair in enumerate(around) if pair}
        since = np.array([1e-9 * (stamp_ns - before.stamp_ns) for before, _ in pairs.values()])
        until = np.array([1e-9 * (after.stamp_ns - stamp_ns) for _, after in pairs.values()])
        self.interval = float((since + until).max())
        return Instant(
            tuple(pairs),
            tuple(
                before if before is after else between(before, after, stamp_ns)
                for before, after in pairs.values()
            ),
            (MRAD * self.acceleration) ** 2 * strays(since, until),
        )


def _about(seen: deque[Sight], stamp_ns: int) -> tuple[Sight, Sight] | None:
    """Return the sights next to an instant, or the same one twice; None without one on a side."""
    before = next((each for each in reversed(seen) if each.stamp_ns <= stamp_ns), None)
    after = next((each for each in seen if each.stamp_ns >= stamp_ns), None)
    return (before, after) if before and after else None


def _apart(before: Sight, after: Sight) -> float:
    """Return the time between two sights, s."""
    return 1e-9 * (after.stamp_ns - before.stamp_ns)

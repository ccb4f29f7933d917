"""How one frame lies in its parent at any instant, from what was said of it."""

from __future__ import annotations

from bisect import bisect_left, bisect_right

from blob_tracker.transforms.errors import NoTransform, TransformError
from blob_tracker.transforms.transform import interpolated, Transform

MOST = 4000  # transforms that are kept: 2 s at 2 kHz


class Link:
    """
    A frame in its parent.

    Parameters
    ----------
    frame, parent : str
        Their names.
    hold_ns : int
        Longest time between two transforms that are interpolated, ns.
    memory_ns : int
        Time for which they are kept, ns.

    Attributes
    ----------
    fixed : Transform or None
        What was said once and for all.

    """

    def __init__(self, frame: str, parent: str, hold_ns: int, memory_ns: int) -> None:
        self.frame, self.parent = frame, parent
        self.fixed: Transform | None = None
        self._hold_ns, self._memory_ns = hold_ns, memory_ns
        self._stamps: list[int] = []
        self._transforms: list[Transform] = []

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest transform, ns; None if none has one."""
        return self._stamps[-1] if self._stamps else None

    def put(self, transform: Transform, stamp_ns: int) -> int:
        """
        Take the transform of an instant; one that says again what is known is no news.

        Returns
        -------
        int
            By how much the stamps jumped back, ns: it is alone then. 0 where they did not.

        Raises
        ------
        TransformError
            If there is another one with this stamp.

        """
        place = len(self._stamps)
        jumped = 0
        if self._stamps and stamp_ns <= self._stamps[-1]:
            late = self._stamps[-1] - stamp_ns
            if late > self._memory_ns:
                jumped = late
                self.forget(-1)
            place = bisect_left(self._stamps, stamp_ns)
            if not jumped and self._stamps[place] == stamp_ns:
                if self._transforms[place] == transform:
                    return 0
                raise TransformError(
                    f'there is another one with the stamp {stamp_ns} ns: two nodes publish it'
                )
        self._stamps.insert(place, stamp_ns)
        self._transforms.insert(place, transform)
        old = bisect_left(self._stamps, self._stamps[-1] - self._memory_ns)
        old = max(old, len(self._stamps) - MOST)
        del self._stamps[:old], self._transforms[:old]
        return jumped

    def forget(self, after_ns: int) -> None:
        """Forget what has a later stamp, ns."""
        end = bisect_right(self._stamps, after_ns)
        del self._stamps[end:], self._transforms[end:]

    def at(self, stamp_ns: int) -> Transform:
        """
        Return the transform at an instant, ns.

        Raises
        ------
        NoTransform
            If it is not known, with a reason. Nothing is extrapolated.

        """
        stamps = self._stamps
        where = f"'{self.frame}' in '{self.parent}'"
        if self.fixed is not None:
            if stamps:
                raise NoTransform(
                    f'{where} comes with and without a time, on /tf and on /tf_static, and may be '
                    'either; let one node publish it'
                )
            return self.fixed
        if not stamps:
            raise NoTransform(f'no transform of {where} has come', may_come=True)
        after = bisect_left(stamps, stamp_ns)
        if after == len(stamps):
            late = stamp_ns - stamps[-1]
            raise NoTransform(
                f'the newest transform of {where} is {1e-9 * late:.3f} s too old',
                may_come=True, frame=self.frame, apart_ns=late,
            )
        if stamps[after] == stamp_ns:
            return self._transforms[after]
        if after == 0:
            early = stamps[0] - stamp_ns
            raise NoTransform(
                f'the oldest transform of {where} that is kept is {1e-9 * early:.3f} s too new',
                frame=self.frame, apart_ns=early,
            )
        before = after - 1
        interval = stamps[after] - stamps[before]
        if interval > self._hold_ns:
            raise NoTransform(
                f'transforms of {where} are {1e-9 * interval:.3f} s apart, and may be '
                f'{1e-9 * self._hold_ns:g} s; publish it more often'
            )
        part = (stamp_ns - stamps[before]) / interval
        return interpolated(self._transforms[before], self._transforms[after], part)

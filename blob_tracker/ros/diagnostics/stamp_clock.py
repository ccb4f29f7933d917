"""By which clock stamps are, told from how far they are from this computer's as they come."""

from __future__ import annotations

from collections import deque
import statistics
import time

from blob_tracker.tracking.memory import MEMORY_NS

# s that a clock is ahead of UTC, for good until the next leap second.
TAI_S, GPS_S = 37.0, 18.0
DELAY_S = 1.0  # at most, from an exposure to here, for a clock to be known by its offset
AHEAD_S = 0.05  # what clocks that are kept by NTP may differ by
RECORDED_S = 10.0  # behind: no camera is so late, a recording is
MEASURED = 10  # stamps


def name_clock(offset: float) -> tuple[str, float | None]:
    """
    Name the clock whose stamps are so far ahead of the system's.

    Parameters
    ----------
    offset : float
        Stamp less time of arrival, s; the delay on the way makes it smaller.

    Returns
    -------
    str, float or None
        Its likely name, and by how much exactly it is ahead, s; None if that is not known.

    """
    boot = time.monotonic() - time.time()
    for name, ahead in (
        ('TAI, which PTP keeps', TAI_S),
        ('GPS time', GPS_S),
        ('the time since this computer was started', boot),
    ):
        if -DELAY_S <= offset - ahead <= AHEAD_S:
            return name, ahead
    if offset > 0.0:
        return 'the clock of another machine', None
    if offset < -RECORDED_S:
        return 'that of a recording, or of another machine', None
    return 'a long way to here, or the clock of another machine', None


class SampleClock:
    """
    Measure how far the stamps of samples are ahead of the system's clock as they come.

    Parameters
    ----------
    latest : float
        s that a stamp may be behind as it comes.

    """

    def __init__(self, latest: float) -> None:
        self.latest = latest
        self._offsets: deque[float] = deque(maxlen=MEASURED)

    def took(self, stamp_ns: int, now_ns: int) -> None:
        """Take note of a stamp and of when it came, ns."""
        offset = 1e-9 * (stamp_ns - now_ns)
        if self._offsets and abs(offset - self._offsets[-1]) > DELAY_S:
            self._offsets.clear()  # the clock was set
        self._offsets.append(offset)

    @property
    def is_measured(self) -> bool:
        """Whether as many have come as it takes."""
        return len(self._offsets) == MEASURED

    @property
    def offset(self) -> float:
        """Return the median, s; 0 before the first."""
        return statistics.median(self._offsets) if self._offsets else 0.0

    @property
    def soonest(self) -> float:
        """Return the offset of the one that came soonest after its instant, s."""
        return max(self._offsets)

    @property
    def fault(self) -> str:
        """Return what is wrong with the stamps, and what to do; else empty."""
        offset = self.offset
        if -self.latest <= offset <= AHEAD_S:
            return ''
        name, known = name_clock(offset)
        return f'{_apart(offset)} ({name}): {_remedy(offset, known, "its driver")}'


def _apart(offset: float) -> str:
    """Return by how much stamps are ahead, in words."""
    side = 'ahead of' if offset > 0.0 else 'behind'
    return f"stamps are {abs(offset):.3f} s {side} this computer's clock as they come"


def _remedy(offset: float, known: float | None, who: str, where: str = '') -> str:
    """Return what to do about stamps that are so far ahead: who is to, and where to look."""
    if known is None and offset < -RECORDED_S:
        return 'play a recording with --clock and set use_sim_time; else set clocks by NTP'
    if known is None and offset < 0.0:
        return f'{where}set clocks by NTP or PTP'
    return f"have {who} stamp by the system's clock"


class StampClock:
    """
    Measure how far stamps are ahead of the system's clock, and take that off.

    Parameters
    ----------
    offset : float
        s that are taken off, where it is not measured.
    auto : bool
        Measure it.
    latest : float
        s that a stamp may be behind as it comes.

    """

    def __init__(self, offset: float = 0.0, *, auto: bool = False, latest: float) -> None:
        self.latest = latest
        self._taken_ns, self._auto = round(1e9 * offset), auto
        self._came = SampleClock(latest)
        self._last_ns = -1  # the last stamp
        self._first_ns = self._again_ns = 0  # when it came first, and last

    def corrected(self, stamp_ns: int, now_ns: int) -> int:
        """
        Return a stamp by the system's clock.

        A clock that is known has an offset that is known; of others the stamps that came soonest
        after their instant are taken to have come at once.

        Parameters
        ----------
        stamp_ns, now_ns : int
            As it came, and when, ns.

        Returns
        -------
        int
            ns.

        """
        if stamp_ns != self._last_ns:
            self._last_ns, self._first_ns = stamp_ns, now_ns
        self._again_ns = now_ns
        self._came.took(stamp_ns, now_ns)
        if self._auto and self._came.is_measured and self.fault and not self._stands:
            _, known = name_clock(self._came.offset)
            self._taken_ns = round(1e9 * (self._came.soonest if known is None else known))
        return stamp_ns - self._taken_ns

    @property
    def taken(self) -> float:
        """Return what is taken off the stamps, s."""
        return 1e-9 * self._taken_ns

    @property
    def _stands(self) -> bool:
        """Tell whether the stamps are no clock's; those of lights seen together are the same."""
        return self._last_ns == 0 or self._again_ns - self._first_ns > 1e9 * DELAY_S

    @property
    def fault(self) -> str:
        """Return what is wrong with the stamps that are left, and what to do; else empty."""
        if self._stands:
            return (
                f'all stamps are {1e-9 * self._last_ns:.3f} s, and nothing can be predicted: have '
                'the camera stamp each image with the middle of its exposure'
            )
        offset = self._came.offset
        left = offset - self.taken
        if self._last_ns < 0 or -self.latest <= left <= AHEAD_S:
            return ''
        name, known = name_clock(offset)
        # Of what is not far ahead the filter still knows where it was.
        so = 'nothing can be predicted'
        if 0.0 < left < 1e-9 * MEMORY_NS:
            so = f'what is predicted is of {left:.3f} s before'
        if self._taken_ns:
            if -self.latest <= offset <= AHEAD_S:
                name, known = "this computer's", 0.0
            return (
                f'{_apart(left)}, with the offset of {self.taken:.3f} s taken off, and {so}: '
                f'without it they are {abs(offset):.3f} s '
                f'{"ahead" if offset > 0.0 else "behind"} (the clock is {name}); set stamp_offset '
                f'to {offset if known is None else known:.3f}{self._or_auto}'
            )
        where = 'see the age in the diagnostics of each node, and '
        return (
            f'{_apart(left)} ({name}), and {so}: {_remedy(left, known, "the camera", where)}; or '
            f'set stamp_offset to {offset if known is None else known:.3f}{self._or_auto}'
        )

    @property
    def _or_auto(self) -> str:
        """Return the other remedy; '' where it is in use."""
        return '' if self._auto else ', or stamp_offset_auto'

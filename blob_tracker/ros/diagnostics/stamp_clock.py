"""By which clock stamps are, told from how far they are from this computer's as they come."""

from __future__ import annotations

from collections import deque
import statistics
import time

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
    return 'a long way from the camera, or the clock of another machine', None


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
        self._offsets: deque[float] = deque(maxlen=MEASURED)

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
        offset = 1e-9 * (stamp_ns - now_ns)
        if self._offsets and abs(offset - self._offsets[-1]) > DELAY_S:
            self._offsets.clear()  # the clock was set
        self._offsets.append(offset)
        if self._auto and len(self._offsets) == MEASURED and self.fault:
            _, known = name_clock(statistics.median(self._offsets))
            self._taken_ns = round(1e9 * (max(self._offsets) if known is None else known))
        return stamp_ns - self._taken_ns

    @property
    def taken(self) -> float:
        """Return what is taken off the stamps, s."""
        return 1e-9 * self._taken_ns

    @property
    def fault(self) -> str:
        """Return what is wrong with the stamps that are left, and what to do; else empty."""
        if not self._offsets:
            return ''
        offset = statistics.median(self._offsets)
        left = offset - self.taken
        if -self.latest <= left <= AHEAD_S:
            return ''
        name, known = name_clock(offset)
        side = 'ahead of' if left > 0.0 else 'behind'
        if self._taken_ns:
            if -self.latest <= offset <= AHEAD_S:
                name, known = "this computer's", 0.0
            return (
                f"stamps are {abs(left):.3f} s {side} this computer's clock as they come, with "
                f'the offset of {self.taken:.3f} s taken off, and nothing can be predicted: '
                f'without it they are {abs(offset):.3f} s '
                f'{"ahead" if offset > 0.0 else "behind"} (the clock is {name}); set stamp_offset '
                f'to {offset if known is None else known:.3f}{self._or_auto}'
            )
        if known is None and left < -RECORDED_S:
            remedy = 'play a recording with --clock and set use_sim_time; else set clocks by NTP'
        elif known is None and left < 0.0:
            remedy = 'see the age in the diagnostics of each node, and set clocks by NTP or PTP'
        else:
            remedy = "have the camera stamp by the system's clock"
        return (
            f"stamps are {abs(left):.3f} s {side} this computer's clock as they come ({name}), "
            f'and nothing can be predicted: {remedy}; or set stamp_offset to '
            f'{offset if known is None else known:.3f}{self._or_auto}'
        )

    @property
    def _or_auto(self) -> str:
        """Return the other remedy; '' where it is in use."""
        return '' if self._auto else ', or stamp_offset_auto'

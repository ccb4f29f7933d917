"""How many messages come in a second, how old they are, and how late their results leave."""

from __future__ import annotations

from array import array
from collections import deque
import statistics
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SECOND_NS = 1e9  # ns
WINDOW_S = 10.0  # s: at 30 Hz the 99th percentile is the third largest of 300
RATE_WINDOW_S = 1.0  # s: the window of the rate
ROOM = 8192  # entries of a ring: the window of 800 Hz
FEW = 5  # arrivals of which a rate is told, however long ago the first of them was
MANY = 300  # results of which three are the late hundredth: one may be the first of all
OLDEST_S = 10.0  # s: an older stamp is one of another clock, such as that of a recording
MINUTE_S, SETTLED_S, LASTING_S = 60, 10, 3  # s: of the usual rate, until there is one, of its fall
AHEAD_S = -0.001  # s: what the rounding of two clocks may do to an age


class Timing:
    """
    Rate, age and latency over the last seconds, in rings that do not grow.

    All times are given by the caller: those of a clock that never jumps to place an event, and the
    age of its stamp by the clock of the stamps.
    """

    def __init__(self) -> None:
        self._arrivals = _Ring()
        self._departures = _Ring()

    def arrived(self, now_ns: int, age_ns: int) -> None:
        """Take a message that came in, with the age of its stamp."""
        self._arrivals.add(now_ns, age_ns)

    def left(self, now_ns: int, age_ns: int) -> None:
        """Take a result that was published, with the age of its stamp."""
        self._departures.add(now_ns, age_ns)

    def figures(self, now_ns: int) -> Figures:
        """Return what is known of the last seconds."""
        times, ages = self._arrivals.events()
        departures, latencies = self._departures.events()
        begin_ns = now_ns - WINDOW_S * SECOND_NS
        ages = ages[np.searchsorted(times, begin_ns):]
        latencies = latencies[np.searchsorted(departures, begin_ns):]
        return Figures(
            rate=_rate(times, now_ns),
            age=_milliseconds(ages, 50.0),
            latency=_milliseconds(latencies, 50.0),
            latency_p99=_milliseconds(latencies, 99.0),
            results=len(latencies),
        )


class Figures(NamedTuple):
    """
    What `Timing` knows of the last seconds.

    Parameters
    ----------
    rate : float
        Messages a second: of the last second, or of the last five messages where those are
        longer ago; it falls with each second of silence.
    age : float
        Median of now - stamp as they arrived in the last 10 s, ms; NaN where none did.
    latency, latency_p99 : float
        Median and 99th percentile of now - stamp as the results of the last 10 s were published,
        ms; NaN where there was none.
    results : int
        Count of the latter.

    """

    rate: float
    age: float
    latency: float
    latency_p99: float
    results: int

    @property
    def uneven(self) -> bool:
        """Tell whether one result in a hundred is later than the others by three messages."""
        known = plausible(self.latency) and plausible(self.latency_p99) and self.rate > 0.0
        late = self.latency_p99 - self.latency
        return known and self.results >= MANY and late > 3e3 / self.rate


def plausible(age: float) -> bool:
    """Tell whether an age in ms can be one: it is none where the stamp is of another clock."""
    return 1e3 * AHEAD_S <= age <= 1e3 * OLDEST_S


class UsualRate:
    """The rate of the last minute, to tell when it falls."""

    def __init__(self) -> None:
        self._rates: deque[float] = deque(maxlen=MINUTE_S)
        self._fallen = 0

    def fell(self, rate: float) -> float | None:
        """
        Take the rate of one more second.

        Parameters
        ----------
        rate : float
            Hz.

        Returns
        -------
        float or None
            The median of the last minute, where the rate has been below half of that for three
            seconds: half a minute later the new one is the usual one. None else.

        """
        usual = statistics.median(self._rates) if len(self._rates) >= SETTLED_S else 0.0
        self._fallen = self._fallen + 1 if rate < 0.5 * usual else 0
        self._rates.append(rate)
        return usual if self._fallen >= LASTING_S else None


class _Ring:
    """The last `ROOM` events, each with its time and an age, ns."""

    def __init__(self) -> None:
        # An element of an array is set in a third of the time that one of NumPy's takes.
        self._times = array('d', bytes(8 * ROOM))
        self._ages = array('d', bytes(8 * ROOM))
        self._taken = 0

    def add(self, now_ns: int, age_ns: int) -> None:
        """Take an event in the place of the oldest."""
        index = self._taken % ROOM
        self._times[index] = now_ns
        self._ages[index] = age_ns
        self._taken += 1

    def events(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return times and ages, the earliest first."""
        order = np.arange(max(self._taken - ROOM, 0), self._taken) % ROOM
        return np.frombuffer(self._times)[order], np.frombuffer(self._ages)[order]


def _rate(times: NDArray[np.float64], now_ns: int) -> float:
    """Return the messages a second at the end of these times."""
    if len(times) < 2:
        return 0.0
    first = int(np.searchsorted(times, now_ns - RATE_WINDOW_S * SECOND_NS))
    recent = min(first, max(len(times) - FEW, 0))
    span = times[-1] - times[recent]
    interval = span / (len(times) - 1 - recent)
    silence = now_ns - times[-1]
    if silence > 2.0 * interval:
        interval = silence  # none came in that time
    return float(SECOND_NS / interval) if interval > 0.0 else 0.0


def _milliseconds(ages_ns: NDArray[np.float64], percentile: float) -> float:
    return float(np.percentile(ages_ns, percentile)) / 1e6 if len(ages_ns) else float('nan')

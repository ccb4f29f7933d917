"""What is measured of the ways of frames, and what comes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import nan
from statistics import median
from typing import Any

import numpy as np

SMALL, USUAL, LARGE = (64, 64), (640, 480), (1920, 1200)
HOP, THREE, ONE = 'bare hop', 'three processes', 'one process'
NO_FRAME = (0, 0)  # the size of a hop that carries a bearing
WARM_UP_S = 1.0  # s

Floats = np.ndarray[Any, np.dtype[np.float64]]
# Of each frame: stamp and monotonic time, ns, whether lit, and when its bearing left, if known.
Sent = Sequence[tuple[int, int, bool]] | Sequence[tuple[int, int, bool, int | None]]


@dataclass(frozen=True)
class Plan:
    """
    How much is measured.

    Parameters
    ----------
    rounds : int
        Of the ways that are compared.
    seconds : float
        Of each stream that counts.
    starts : int
        Starts of the nodes.

    """

    rounds: int
    seconds: float
    starts: int


FULL = Plan(rounds=4, seconds=10.0, starts=5)
QUICK = Plan(rounds=2, seconds=3.0, starts=1)


@dataclass(frozen=True)
class Row:
    """
    One way at one size and rate.

    Parameters
    ----------
    way : str
        Which.
    size : (int, int)
        Width and height of the frames, px.
    rate : float
        Frames a second.
    medians, tails : list of float
        Median and 99th percentile of each round, s.
    late : float
        99.9th percentile of all rounds together, s.
    over_hops, tails_over_hops : float
        Median over the rounds of median and 99th percentile over the sum of those of the bare
        hops that the way is compared with; NaN where it is with none.
    expected, lost : int
        Messages that should have come, and those of them that did not.
    busy : dict
        Share of one core that each process used.

    """

    way: str
    size: tuple[int, int]
    rate: float
    medians: list[float]
    tails: list[float]
    late: float
    over_hops: float = nan
    tails_over_hops: float = nan
    expected: int = 0
    lost: int = 0
    busy: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Start:
    """
    Start of the nodes while the camera is already publishing.

    Parameters
    ----------
    way : str
        Which.
    seconds : list of float
        From the start of the processes to the first bearing received, of each start.

    """

    way: str
    seconds: list[float]


@dataclass(frozen=True)
class Resident:
    """
    What a node takes beside processor time.

    Parameters
    ----------
    node : str
        Which.
    memory : float
        Resident, the most of the rounds at 640 x 480, MB.
    own : float
        Of it what no other process can share: all but the pages of libraries' files, MB.
    growth : float
        Slope of the memory over the rounds at 640 x 480 after the first, MB a minute.
    pause : float
        Longest garbage collection while frames came, s.
    collections : int
        How many of them.

    """

    node: str
    memory: float
    own: float
    growth: float
    pause: float
    collections: int


@dataclass(frozen=True)
class Comparison:
    """
    A figure of this source tree and of another one.

    Parameters
    ----------
    what, unit : str
        Which.
    own, other : float
        Medians over the rounds; of the 99.9th percentile, of all rounds together.
    ratio : float
        Median over the rounds of the one over the other; or the one over the other.

    """

    what: str
    unit: str
    own: float
    other: float
    ratio: float


@dataclass(frozen=True)
class Figures:
    """All that a run finds; only `beside` where two source trees are compared."""

    rows: list[Row] = field(default_factory=list)
    starts: list[Start] = field(default_factory=list)
    residents: list[Resident] = field(default_factory=list)
    beside: list[Comparison] = field(default_factory=list)


@dataclass
class Stream:
    """
    One stream of frames and what came of it.

    Parameters
    ----------
    delays : (n,) array
        Of the messages that came, s.
    expected : int
        How many should have come.
    busy : dict
        Share of one core of each process.
    handed : (m,) array
        Of the bearings that left for Fast DDS in the process that had the frame, s; empty if
        that is another one.

    """

    delays: Floats
    expected: int
    busy: dict[str, float] = field(default_factory=dict)
    handed: Floats = field(default_factory=lambda: np.empty(0))

    @property
    def lost(self) -> int:
        """Messages that did not come."""
        return self.expected - len(self.delays)


def pair(
    sent: Sent,
    arrived: Sequence[tuple[int, int]],
    *,
    lit_alone: bool,
    warm_up: float = WARM_UP_S,
) -> Stream:
    """
    Pair what was sent with what arrived, by the stamp.

    Parameters
    ----------
    sent : sequence of (int, int, bool) or (int, int, bool, int or None)
        Stamp, monotonic time and whether lit, ns; of a process that publishes bearings itself,
        when it did.
    arrived : sequence of (int, int)
        Stamp and monotonic time, ns.
    lit_alone : bool
        Whether the lit frames alone have an answer.
    warm_up : float
        Time at the beginning that does not count, s.

    """
    times = dict(arrived)
    first_ns = sent[0][1] + int(1e9 * warm_up)
    counted = [
        (stamp_ns, left_ns, handed_ns) for stamp_ns, left_ns, lit, *handed_ns in sent
        if left_ns >= first_ns and (lit or not lit_alone)
    ]
    delays = [times[stamp] - left_ns for stamp, left_ns, _ in counted if stamp in times]
    handed = [each - left_ns for _, left_ns, told in counted for each in told if each is not None]
    return Stream(np.array(delays) / 1e9, len(counted), handed=np.array(handed) / 1e9)


def row(
    way: str, size: tuple[int, int], rate: float, streams: Sequence[Stream],
    hops: Sequence[Sequence[Stream]] = (),
) -> Row:
    """Return the row of a way's rounds; `hops` are those of each bare hop, round by round."""
    came = np.concatenate([each.delays for each in streams])
    medians = [percentile(each.delays, 50.0) for each in streams]
    tails = [percentile(each.delays, 99.0) for each in streams]
    names = streams[0].busy
    return Row(
        way, size, rate, medians, tails,
        percentile(came, 99.9),
        _over(medians, hops, 50.0),
        _over(tails, hops, 99.0),
        sum(each.expected for each in streams),
        sum(each.lost for each in streams),
        {name: median(each.busy[name] for each in streams) for name in names},
    )


def percentile(delays: Floats, percent: float) -> float:
    """Return a percentile of delays, s; NaN where nothing came."""
    return float(np.percentile(delays, percent)) if len(delays) else nan


def _over(own: Sequence[float], hops: Sequence[Sequence[Stream]], percent: float) -> float:
    """Return the median over the rounds of a figure over the sum of that of the hops."""
    if not hops:
        return nan
    sums = [sum(percentile(each.delays, percent) for each in round_) for round_ in zip(*hops)]
    return median(figure / total for figure, total in zip(own, sums))

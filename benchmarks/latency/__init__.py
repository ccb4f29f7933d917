"""
From a frame to its bearing in another process, beside bare hops of rclpy.

Each way is walked by real processes over Fast DDS with the profile that the package ships. The
hops and the tracker take turns at the same rate, round after round, so that a busy machine slows
both. A way begins just before publish() (in one process: before the frame is handed over) and ends
where the callback of a plain rclpy subscriber begins; the first second of a stream does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
import json
from math import nan
from statistics import median
import time
from typing import Any

from benchmarks.latency.process import Process
import numpy as np

Tick = Callable[[str], None]

SMALL, USUAL, LARGE = (64, 64), (640, 480), (1920, 1200)
HOP, THREE, ONE = 'bare hop', 'three processes', 'one process'
NO_FRAME = (0, 0)  # the size of a hop that carries a bearing
NAMESPACE = 'one'  # of the pipeline: it lives beside the three
WARM_UP = 1.0  # s
GRACE = 0.3  # s after the end of a stream for the last message
LONGEST_START = 20.0  # s that the nodes have to start
MEETINGS = 20  # streams until the first bearing


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
class Figures:
    """All that a run finds."""

    rows: list[Row] = field(default_factory=list)
    starts: list[Start] = field(default_factory=list)
    residents: list[Resident] = field(default_factory=list)


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

    """

    delays: np.ndarray[Any, np.dtype[np.float64]]
    expected: int
    busy: dict[str, float] = field(default_factory=dict)

    @property
    def lost(self) -> int:
        """Messages that did not come."""
        return self.expected - len(self.delays)


def pair(
    sent: Sequence[tuple[int, int, bool]],
    arrived: Sequence[tuple[int, int]],
    *,
    lit_alone: bool,
    warm_up: float = WARM_UP,
) -> Stream:
    """
    Pair what was sent with what arrived, by the stamp.

    Parameters
    ----------
    sent : sequence of (int, int, bool)
        Stamp, monotonic time and whether lit, ns.
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
        (stamp_ns, left_ns) for stamp_ns, left_ns, lit in sent
        if left_ns >= first_ns and (lit or not lit_alone)
    ]
    delays = [times[stamp] - left_ns for stamp, left_ns in counted if stamp in times]
    return Stream(np.array(delays) / 1e9, len(counted))


def row(
    way: str, size: tuple[int, int], rate: float, streams: Sequence[Stream],
    hops: Sequence[Sequence[Stream]] = (),
) -> Row:
    """Return the row of a way's rounds; `hops` are those of each bare hop, round by round."""
    came = np.concatenate([each.delays for each in streams])
    medians = [_percentile(each, 50.0) for each in streams]
    tails = [_percentile(each, 99.0) for each in streams]
    names = streams[0].busy
    return Row(
        way, size, rate, medians, tails,
        float(np.percentile(came, 99.9)) if len(came) else nan,
        _over(medians, hops, 50.0),
        _over(tails, hops, 99.0),
        sum(each.expected for each in streams),
        sum(each.lost for each in streams),
        {name: median(each.busy[name] for each in streams) for name in names},
    )


def _percentile(each: Stream, percent: float) -> float:
    return float(np.percentile(each.delays, percent)) if len(each.delays) else nan


def _over(own: Sequence[float], hops: Sequence[Sequence[Stream]], percent: float) -> float:
    """Return the median over the rounds of a figure over the sum of that of the hops."""
    if not hops:
        return nan
    sums = [sum(_percentile(each, percent) for each in round_) for round_ in zip(*hops)]
    return median(figure / total for figure, total in zip(own, sums))


def steps(plan: Plan) -> int:
    """Return how many ticks `run` makes."""
    return plan.starts + plan.rounds + 4


def run(plan: Plan, tick: Tick) -> Figures:
    """Measure all."""
    starts = []
    for index in range(plan.starts):
        tick(f'start-up {index + 1}')
        starts.append([_start(way) for way in (THREE, ONE)])
    with ExitStack() as stack:
        nodes = Nodes(stack, tick)
        rounds = [nodes.one_round(plan.seconds, index) for index in range(plan.rounds)]
        small, usual, bearing, three, one = zip(*rounds)
        rows = [
            row(HOP, SMALL, 60.0, small),
            row(HOP, USUAL, 60.0, usual),
            # Of a frame and the unlit one after it comes one bearing.
            row(HOP, NO_FRAME, 30.0, bearing),
            row(THREE, USUAL, 60.0, three, (small, usual)),
            row(ONE, USUAL, 60.0, one, (small,)),
        ]
        for way, size, rate in (
            (THREE, USUAL, 300.0), (ONE, USUAL, 500.0), (THREE, LARGE, 60.0), (ONE, LARGE, 60.0),
        ):
            tick(f'{way}, {size[0]} x {size[1]}, {rate:g} Hz')
            rows.append(row(way, size, rate, [nodes.walk(way, size, rate, plan.seconds)]))
        residents = nodes.end()
    return Figures(
        rows, [Start(way, list(each)) for way, each in zip((THREE, ONE), zip(*starts))], residents
    )


class Nodes:
    """
    The tracker as three processes (the camera is this benchmark's own) and as one.

    Parameters
    ----------
    stack : ExitStack
        Ends them.
    tick : callable
        Hears what is measured.

    """

    def __init__(self, stack: ExitStack, tick: Tick) -> None:
        self._tick = tick
        self._three = {
            name: stack.enter_context(Process('node', name)) for name in ('segmenter', 'locator')
        }
        self._one = stack.enter_context(
            Process('pipeline', '--ros-args', '-r', f'__ns:=/{NAMESPACE}')
        )
        self._camera = stack.enter_context(_camera('camera', info=True, subscribers=1))
        self._camera.answer()
        self._listeners = {
            way: stack.enter_context(Process('subscriber', 'bearing', topic))
            for way, topic in (
                (THREE, 'target/bearing'), (ONE, f'{NAMESPACE}/target/bearing'),
            )
        }
        for way, listener in self._listeners.items():
            listener.answer()
            self._meet(way, listener)
        self._streams: list[tuple[int, int]] = []  # begin and end of each, monotonic, ns
        self._memory: dict[str, list[tuple[float, float, float]]] = {}  # when, all, its own

    @property
    def _all(self) -> dict[str, Process]:
        return {**self._three, 'pipeline': self._one}

    def one_round(self, seconds: float, index: int) -> list[Stream]:
        """Walk the hops and both ways once at 60 Hz, lit and unlit in turn."""
        self._tick(f'ways and bare hops at 60 Hz, round {index + 1}')
        streams = [
            hop(SMALL, 60.0, seconds),
            hop(USUAL, 60.0, seconds),
            bearing_hop(30.0, seconds),
            self.walk(THREE, USUAL, 60.0, seconds),
            self.walk(ONE, USUAL, 60.0, seconds),
        ]
        for name, process in self._all.items():
            self._memory.setdefault(name, []).append(
                (time.monotonic(), process.memory(), process.own_memory())
            )
        return streams

    def _meet(self, way: str, listener: Process) -> None:
        """Stream until a bearing has come: at times Fast DDS takes seconds to match the topics."""
        listener.ask('first')
        for _ in range(MEETINGS):
            self._stream(way, USUAL, 60.0, 0.5)
            try:
                listener.answer(GRACE)
            except TimeoutError:
                continue
            return
        raise TimeoutError(f'{way}: no bearing comes')

    def _stream(
        self, way: str, size: tuple[int, int], rate: float, seconds: float
    ) -> list[tuple[int, int, bool]]:
        """Send frames on one of the ways; return what was sent."""
        sender = self._camera if way == THREE else self._one
        return _stream(sender, size, rate, seconds)

    def walk(self, way: str, size: tuple[int, int], rate: float, seconds: float) -> Stream:
        """Stream once through one of the ways."""
        processes = self._three if way == THREE else {'pipeline': self._one}
        listener = self._listeners[way]
        self._stream(way, size, rate, 0.0)
        _arrived(listener)  # what came late of the stream before
        began_ns = time.monotonic_ns()
        busy = {name: -process.busy() for name, process in processes.items()}
        sent = self._stream(way, size, rate, WARM_UP + seconds)
        time.sleep(GRACE)
        found = pair(sent, _arrived(listener), lit_alone=True)
        lasted = (sent[-1][1] - sent[0][1]) / 1e9
        found.busy = {
            name: (busy[name] + process.busy()) / lasted for name, process in processes.items()
        }
        self._streams.append((began_ns, time.monotonic_ns()))
        return found

    def end(self) -> list[Resident]:
        """End all nodes and return what they took."""
        for process in self._three.values():
            process.interrupt()
        self._one.close_input()
        residents = []
        for name, process in self._all.items():
            pauses = [
                length_ns / 1e9 for at_ns, length_ns in process.answer()
                if any(begin_ns <= at_ns <= end_ns for begin_ns, end_ns in self._streams)
            ]
            when, memory, own = np.array(self._memory[name]).T
            growth = nan
            if len(when) > 2:
                growth = float(np.polyfit((when[1:] - when[1]) / 60.0, memory[1:], 1)[0])
            residents.append(Resident(
                name, float(memory.max()), float(own.max()), growth, max(pauses, default=0.0),
                len(pauses),
            ))
        return residents


def hop(
    size: tuple[int, int], rate: float, seconds: float, warm_up: float = WARM_UP
) -> Stream:
    """Publish images in one process and receive them in another."""
    with ExitStack() as stack:
        subscriber = stack.enter_context(Process('subscriber', 'image', 'hop/image_raw'))
        camera = stack.enter_context(_camera('hop', info=False, subscribers=1))
        subscriber.answer()
        camera.answer()
        sent = _stream(camera, size, rate, warm_up + seconds)
        return pair(sent, _arrived(subscriber), lit_alone=False, warm_up=warm_up)


def bearing_hop(rate: float, seconds: float) -> Stream:
    """Publish bearings in one process and receive them in another."""
    with ExitStack() as stack:
        subscriber = stack.enter_context(Process('subscriber', 'bearing', 'hop/bearing'))
        sender = stack.enter_context(Process('bearings', 'hop/bearing'))
        subscriber.answer()
        sender.answer()
        sender.ask({'rate': rate, 'seconds': WARM_UP + seconds})
        return pair(sender.answer(), _arrived(subscriber), lit_alone=False)


def _arrived(subscriber: Process) -> Sequence[tuple[int, int]]:
    """Return what a subscriber received since it was asked last."""
    subscriber.ask('new')
    return subscriber.answer()


def _start(way: str) -> float:
    """Return the seconds from the start of a way's nodes to the first bearing received."""
    with ExitStack() as stack:
        subscriber = stack.enter_context(Process('subscriber', 'bearing', 'target/bearing'))
        camera = stack.enter_context(_camera('camera', info=True, subscribers=0))
        subscriber.answer()
        camera.answer()
        camera.ask(_request(USUAL, 60.0, 2.0 * LONGEST_START))
        subscriber.ask('first')
        began_ns = time.monotonic_ns()
        if way == THREE:
            stack.enter_context(Process('node', 'segmenter'))
            stack.enter_context(Process('node', 'locator'))
        else:
            stack.enter_context(Process('node', 'pipeline', '--ros-args', '-p', 'source:=images'))
        try:
            _, at_ns = subscriber.answer(LONGEST_START)
        except TimeoutError:
            return nan
    return (at_ns - began_ns) / 1e9


def _camera(topic: str, *, info: bool, subscribers: int) -> Process:
    """Start a camera; it says `[]` when so many have subscribed."""
    options = {'topic': topic, 'info': info, 'subscribers': subscribers}
    return Process('camera', json.dumps(options))


def _stream(
    sender: Process, size: tuple[int, int], rate: float, seconds: float
) -> list[tuple[int, int, bool]]:
    """Have frames sent; return stamp and monotonic time, ns, and whether lit, of each."""
    sender.ask(_request(size, rate, seconds))
    sent: list[tuple[int, int, bool]] = sender.answer()
    return sent


def _request(size: tuple[int, int], rate: float, seconds: float) -> dict[str, float]:
    return {'width': size[0], 'height': size[1], 'rate': rate, 'seconds': seconds}

"""The tracker as three processes and as one, and bare hops beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
import json
from math import nan
from pathlib import Path
import time

from benchmarks.latency.figures import (
    ONE, pair, Resident, Sent, SMALL, Stream, THREE, USUAL, WARM_UP_S,
)
from benchmarks.latency.process import Process, ROOT
import numpy as np

Tick = Callable[[str], None]
NAMESPACE = 'one'  # of the pipeline: it lives beside the three
GRACE_S = 0.3  # s after the end of a stream for the last message
LONGEST_START_S = 20.0  # s that the nodes have to start
MEETINGS = 20  # streams until the first bearing
# Another tree need not have them.
HANDED, TAKEN, MANY, STARTED = (
    str(ROOT / 'benchmarks' / 'latency' / f'{name}.py')
    for name in ('handed', 'taken', 'many', 'started')
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
    root : Path
        The source tree that they are of.
    timed : bool
        Whether the three note how long each of them has a frame: see `own_times`. `end` has no
        answer then.

    """

    def __init__(
        self, stack: ExitStack, tick: Tick, root: Path = ROOT, *, timed: bool = False
    ) -> None:
        self._tick = tick
        self._three = {
            name: stack.enter_context(Process(*([TAKEN] if timed else ['node']), name, root=root))
            for name in ('segmenter', 'locator')
        }
        self._one = stack.enter_context(
            Process(HANDED, '--ros-args', '-r', f'__ns:=/{NAMESPACE}', root=root)
        )
        self._camera = stack.enter_context(_camera('camera', info=True, subscribers=1, root=root))
        self._camera.answer()
        self._listeners = {
            way: stack.enter_context(Process('subscriber', 'bearing', topic, root=root))
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
                listener.answer(GRACE_S)
            except TimeoutError:
                continue
            return
        raise TimeoutError(f'{way}: no bearing comes')

    def _stream(
        self, way: str, size: tuple[int, int], rate: float, seconds: float
    ) -> Sent:
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
        sent = self._stream(way, size, rate, WARM_UP_S + seconds)
        time.sleep(GRACE_S)
        found = pair(sent, _arrived(listener), lit_alone=True)
        lasted = (sent[-1][1] - sent[0][1]) / 1e9
        found.busy = {
            name: (busy[name] + process.busy()) / lasted for name, process in processes.items()
        }
        self._streams.append((began_ns, time.monotonic_ns()))
        return found

    def proportional_memory(self) -> dict[str, float]:
        """Return the memory of each node, its part of what it shares with others, MB."""
        self._stream(ONE, USUAL, 60.0, 0.0)  # the frames that it is fed with are in its process
        return {name: each.proportional_memory() for name, each in self._all.items()}

    def own_times(self) -> dict[str, list[float]]:
        """Return how long each of the three had each message since the last question, us."""
        for process in self._three.values():
            process.ask('new')
        return {name: process.answer() for name, process in self._three.items()}

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
    size: tuple[int, int], rate: float, seconds: float, warm_up: float = WARM_UP_S
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
        sender.ask({'rate': rate, 'seconds': WARM_UP_S + seconds})
        return pair(sender.answer(), _arrived(subscriber), lit_alone=False)


def _arrived(subscriber: Process) -> Sequence[tuple[int, int]]:
    """Return what a subscriber received since it was asked last."""
    subscriber.ask('new')
    return subscriber.answer()


def first_bearing(way: str, root: Path = ROOT) -> float:
    """Return the seconds from the start of a way's nodes to the first bearing received."""
    with ExitStack() as stack:
        subscriber = stack.enter_context(
            Process('subscriber', 'bearing', 'target/bearing', root=root)
        )
        camera = stack.enter_context(_camera('camera', info=True, subscribers=0, root=root))
        subscriber.answer()
        camera.answer()
        _stream(camera, USUAL, 60.0, 0.0)  # draws the frames: it takes as long as a start
        camera.ask(_request(USUAL, 60.0, 2.0 * LONGEST_START_S))
        subscriber.ask('first')
        began_ns = time.monotonic_ns()
        if way == THREE:
            stack.enter_context(Process(STARTED, 'segmenter', root=root))
            stack.enter_context(Process(STARTED, 'locator', root=root))
        else:
            stack.enter_context(
                Process(STARTED, 'pipeline', '--ros-args', '-p', 'source:=images', root=root)
            )
        try:
            _, at_ns = subscriber.answer(LONGEST_START_S)
        except TimeoutError:
            return nan
    return (at_ns - began_ns) / 1e9


def many_lights(root: Path = ROOT) -> list[float | None]:
    """Return what many.py prints."""
    with Process(MANY, root=root) as process:
        found: list[float | None] = process.answer()
        return found


def help_time(root: Path = ROOT) -> float:
    """Return how long a node takes to say what it is, s."""
    began = time.monotonic()
    with Process(STARTED, 'segmenter', '--help', root=root) as process:
        process.wait()
    return time.monotonic() - began


def _camera(topic: str, *, info: bool, subscribers: int, root: Path = ROOT) -> Process:
    """Start a camera; it says `[]` when so many have subscribed."""
    options = {'topic': topic, 'info': info, 'subscribers': subscribers}
    return Process('camera', json.dumps(options), root=root)


def _stream(
    sender: Process, size: tuple[int, int], rate: float, seconds: float
) -> Sent:
    """Have frames sent; return what `pair` takes of each."""
    sender.ask(_request(size, rate, seconds))
    sent: Sent = sender.answer()
    return sent


def _request(size: tuple[int, int], rate: float, seconds: float) -> dict[str, float]:
    return {'width': size[0], 'height': size[1], 'rate': rate, 'seconds': seconds}

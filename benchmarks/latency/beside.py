"""The nodes of this source tree beside those of another one, in the same run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
from dataclasses import astuple
from math import nan
from pathlib import Path
from statistics import median
import subprocess
import sys
from typing import NamedTuple

from benchmarks.latency.figures import (
    Comparison, Floats, LARGE, ONE, percentile, Plan, Stream, THREE, USUAL,
)
from benchmarks.latency.nodes import first_bearing, help_time, many_lights, Nodes, Tick
from benchmarks.latency.process import environment, ROOT
import numpy as np

COMPILE = (
    'import blob_tracker.nodes.pipeline\n'
    'from blob_tracker.pipeline import compile_ahead\ncompile_ahead()'
)
LOAD = 'while True: pass'
MOST = Plan(rounds=4, seconds=5.0, starts=3)  # of both trees: in ten minutes
FEWEST = 1000  # delays of which one in a thousand is told


class Walk(NamedTuple):
    """A way, the size of its frames, and how many there are a second."""

    way: str
    size: tuple[int, int]
    rate: float

    @property
    def name(self) -> str:
        """Return it in words."""
        width, height = self.size
        return f'{self.way}, {width} x {height}, {self.rate:g} Hz'


# One after the other those whose frames are the same: they are drawn anew for each other kind.
WALKS = (
    *(Walk(ONE, size, rate) for size, rate in ((USUAL, 500.0), (USUAL, 60.0), (LARGE, 60.0))),
    Walk(THREE, USUAL, 60.0),
)
FIRST = 60  # messages of a node that do not count: those of the first second


class _Rounds:
    """What was measured of both trees, figure by figure."""

    def __init__(self) -> None:
        self._values: dict[tuple[str, str], tuple[list[float], list[float]]] = {}
        self._delays: dict[str, tuple[list[Floats], list[Floats]]] = {}

    def add(self, side: int, what: str, unit: str, value: float) -> None:
        """Take a figure of a round."""
        self._values.setdefault((what, unit), ([], []))[side].append(value)

    def add_delays(self, side: int, what: str, delays: Floats) -> None:
        """Take the delays of a stream, s."""
        for percent, name in ((50.0, 'median'), (99.0, 'p99')):
            self.add(side, f'{what}: {name}', 'ms', 1e3 * percentile(delays, percent))
        self._delays.setdefault(what, ([], []))[side].append(delays)

    def figures(self) -> list[Comparison]:
        """Return the figures of both, and the ratios."""
        found = [
            Comparison(
                what, unit, median(own), median(others),
                median(here / there for here, there in zip(own, others)),
            )
            for (what, unit), (own, others) in self._values.items()
        ]
        for what, sides in self._delays.items():
            here, there = (np.concatenate(each) for each in sides)
            if min(len(here), len(there)) >= FEWEST:
                own, other = (1e3 * percentile(each, 99.9) for each in (here, there))
                found.append(Comparison(f'{what}: p99.9', 'ms', own, other, own / other))
        return sorted(found, key=lambda each: each.what.partition(':')[0])


def steps(plan: Plan) -> int:
    """Return how many ticks `compare` makes."""
    plan = _shorter(plan)
    return 2 + plan.starts + plan.rounds


def _shorter(plan: Plan) -> Plan:
    """Return no more than `MOST` of a plan: there are two trees."""
    return Plan(*map(min, astuple(plan), astuple(MOST)))


def compare(other: Path, plan: Plan, tick: Tick, *, load: bool = False) -> list[Comparison]:
    """
    Measure the nodes of this tree and of another one in turns, round after round.

    Each tree's nodes are fed and listened to by its own benchmarks, in a domain of its own.

    Parameters
    ----------
    other : Path
        The other source tree, which has benchmarks/latency as well: a work tree of a commit.
    plan : Plan
        How much.
    tick : callable
        Hears what is measured.
    load : bool
        Whether another process keeps a core busy all the while.

    """
    plan = _shorter(plan)
    trees = ROOT, other.resolve()
    tick('compiling what is not compiled yet')
    for root in trees:
        subprocess.run(
            [sys.executable, '-c', COMPILE], cwd=root, env=environment(root), check=True
        )
    found = _Rounds()
    with _load(load):
        for index in range(plan.starts):
            tick(f'start-up {index + 1}')
            for side in _turn(index):
                found.add(side, '--help of a node', 's', help_time(trees[side]))
                for way in (THREE, ONE):
                    seconds = first_bearing(way, trees[side])
                    found.add(side, f'start to first bearing, {way}', 's', seconds)
        tick('many lights')
        for index in range(plan.starts):
            for side in _turn(index):
                _note_many(found, side, many_lights(trees[side]))
        with ExitStack() as stack:
            nodes = [Nodes(stack, tick, root, timed=True) for root in trees]
            for index in range(plan.rounds):
                tick(f'both trees, round {index + 1}')
                for walk in WALKS:
                    for side in _turn(index):
                        nodes[side].own_times()  # of the stream before
                        stream = nodes[side].walk(walk.way, walk.size, walk.rate, plan.seconds)
                        _note(found, side, walk.name, stream)
                        if walk.way == THREE:
                            _note_own(found, side, walk.name, nodes[side].own_times())
                for side in _turn(index):
                    for name, memory in nodes[side].proportional_memory().items():
                        found.add(side, f'memory (PSS), {name}', 'MB', memory)
    return found.figures()


def _turn(index: int) -> tuple[int, int]:
    """Return who comes first in a round: each in every other one."""
    return (0, 1) if index % 2 == 0 else (1, 0)


@contextmanager
def _load(loaded: bool) -> Iterator[None]:
    """Keep a core busy, if it is to be."""
    if not loaded:
        yield
        return
    process = subprocess.Popen([sys.executable, '-c', LOAD])
    try:
        yield
    finally:
        process.kill()
        process.wait()


def _note(found: _Rounds, side: int, name: str, stream: Stream) -> None:
    """Take what one stream shows."""
    found.add_delays(side, f'frame to bearing elsewhere, {name}', stream.delays)
    if len(stream.handed):
        found.add_delays(side, f'frame to bearing in the hand of DDS, {name}', stream.handed)
    found.add(side, f'of one core, {name}', '%', 100.0 * sum(stream.busy.values()))


def _note_own(found: _Rounds, side: int, name: str, times: dict[str, list[float]]) -> None:
    """Take how long the nodes had what a bearing takes: a lit frame (every other) and a window."""
    middles = {'segmenter': 75.0, 'locator': 50.0}
    total = sum(
        percentile(np.array(times[node][FIRST:]), middle) for node, middle in middles.items()
    )
    found.add(side, f"the nodes' own time of a lit frame, {name}", 'us', total)


def _note_many(found: _Rounds, side: int, seconds: list[float | None]) -> None:
    """Take what many lights cost."""
    coded, stars = (nan if each is None else each for each in seconds)
    found.add(side, 'of one core, 16 coded lights, 752 x 480, 60 Hz', '%', 100.0 * 60.0 * coded)
    found.add(side, '1000 stars, mode steady, 1920 x 1200', 'ms', 1e3 * stars)

"""The nodes of this source tree beside those of another one, in the same run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
from pathlib import Path
from statistics import median
import subprocess
import sys
from typing import NamedTuple

from benchmarks.latency.figures import (
    Comparison, Floats, LARGE, ONE, percentile, Plan, Stream, THREE, USUAL,
)
from benchmarks.latency.nodes import first_bearing, Nodes, Tick
from benchmarks.latency.process import environment, ROOT
import numpy as np

COMPILE = 'from blob_tracker.pipeline import compile_ahead; compile_ahead()'
LOAD = 'while True: pass'
FEWEST = 1000  # delays of which one in a thousand is told


class Walk(NamedTuple):
    """A way, the size of its frames, how many there are a second, and whether a core is busy."""

    way: str
    size: tuple[int, int]
    rate: float
    loaded: bool = False

    @property
    def name(self) -> str:
        """Return it in words."""
        width, height = self.size
        return (
            f'{self.way}, {width} x {height}, {self.rate:g} Hz'
            f'{", beside a load" if self.loaded else ""}'
        )


# One after the other those whose frames are the same: they are drawn anew for each other kind.
WALKS = (
    *(
        Walk(ONE, size, rate, loaded)
        for size, rate in ((USUAL, 500.0), (USUAL, 60.0), (LARGE, 60.0))
        for loaded in (False, True)
    ),
    Walk(THREE, USUAL, 60.0),
)


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
    return 1 + plan.starts + plan.rounds


def compare(other: Path, plan: Plan, tick: Tick) -> list[Comparison]:
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

    """
    trees = ROOT, other.resolve()
    tick('compiling what is not compiled yet')
    for root in trees:
        subprocess.run(
            [sys.executable, '-c', COMPILE], cwd=root, env=environment(root), check=True
        )
    found = _Rounds()
    for index in range(plan.starts):
        tick(f'start-up {index + 1}')
        for side in _turn(index):
            for way in (THREE, ONE):
                seconds = first_bearing(way, trees[side])
                found.add(side, f'start to first bearing, {way}', 's', seconds)
    with ExitStack() as stack:
        nodes = [Nodes(stack, tick, root) for root in trees]
        for index in range(plan.rounds):
            tick(f'both trees, round {index + 1}')
            for walk in WALKS:
                with _load(walk.loaded):
                    for side in _turn(index):
                        stream = nodes[side].walk(walk.way, walk.size, walk.rate, plan.seconds)
                        _note(found, side, walk.name, stream)
            for side in _turn(index):
                for way in (ONE, THREE):
                    memory = nodes[side].proportional_memory(way)
                    found.add(side, f'memory (PSS), {way}', 'MB', memory)
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

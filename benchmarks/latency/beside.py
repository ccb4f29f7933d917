"""The nodes of this source tree beside those of another one, in the same run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from statistics import median
import subprocess
import sys

from benchmarks.latency.figures import Comparison, ONE, percentile, Plan, THREE, USUAL
from benchmarks.latency.nodes import first_bearing, Nodes, Tick
from benchmarks.latency.process import environment, ROOT

WALKS = ((ONE, 500.0), (ONE, 60.0), (THREE, 60.0))  # ways and their frames a second
COMPILE = 'from blob_tracker.pipeline import compile_ahead; compile_ahead()'


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
    found: dict[tuple[str, str], tuple[list[float], list[float]]] = {}

    def note(side: int, figures: Iterator[tuple[str, str, float]]) -> None:
        for what, unit, value in figures:
            found.setdefault((what, unit), ([], []))[side].append(value)

    for index in range(plan.starts):
        tick(f'start-up {index + 1}')
        for side in _turn(index):
            note(side, (
                (f'start to first bearing, {way}', 's', first_bearing(way, trees[side]))
                for way in (THREE, ONE)
            ))
    with ExitStack() as stack:
        nodes = [Nodes(stack, tick, root) for root in trees]
        for index in range(plan.rounds):
            tick(f'both trees, round {index + 1}')
            for way, rate in WALKS:
                for side in _turn(index):
                    note(side, _walk(nodes[side], way, rate, plan.seconds))
            for side in _turn(index):
                note(side, (
                    (f'memory (PSS), {way}', 'MB', nodes[side].proportional_memory(way))
                    for way in (ONE, THREE)
                ))
    return [
        Comparison(
            what, unit, median(own), median(others),
            median(here / there for here, there in zip(own, others)),
        )
        for (what, unit), (own, others) in found.items()
    ]


def _turn(index: int) -> tuple[int, int]:
    """Return who comes first in a round: each in every other one."""
    return (0, 1) if index % 2 == 0 else (1, 0)


def _walk(nodes: Nodes, way: str, rate: float, seconds: float) -> Iterator[tuple[str, str, float]]:
    """Yield what one stream shows."""
    stream = nodes.walk(way, USUAL, rate, seconds)
    where = f'{way}, {rate:g} Hz'
    yield f'frame to bearing, {where}: median', 'ms', 1e3 * percentile(stream, 50.0)
    yield f'the same: p99, {where}', 'ms', 1e3 * percentile(stream, 99.0)
    yield f'of one core, {where}', '%', 100.0 * sum(stream.busy.values())

"""
From a frame to its bearing in another process, beside bare hops of rclpy.

Each way is walked by real processes over Fast DDS with the profile that the package ships. The
hops and the tracker take turns at the same rate, round after round, so that a busy machine slows
both. A way begins just before publish() (in one process: before the frame is handed over) and ends
where the callback of a plain rclpy subscriber begins; the first second of a stream does not count.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from benchmarks.latency.beside import compare, steps as steps_beside
from benchmarks.latency.figures import (
    Figures, FULL, HOP, LARGE, NO_FRAME, ONE, pair, Plan, QUICK, row, SMALL, Start, Stream, THREE,
    USUAL,
)
from benchmarks.latency.nodes import first_bearing, hop, Nodes, Tick

__all__ = ['Figures', 'FULL', 'hop', 'pair', 'Plan', 'QUICK', 'row', 'run', 'steps', 'Stream']


def steps(plan: Plan, beside: Path | None = None) -> int:
    """Return how many ticks `run` makes."""
    return plan.starts + plan.rounds + 4 if beside is None else steps_beside(plan)


def run(
    plan: Plan, tick: Tick, beside: Path | None = None, *, load: bool = False
) -> Figures:
    """Measure all; or the nodes alone, beside those of another tree and perhaps a load."""
    if beside is not None:
        return Figures(beside=compare(beside, plan, tick, load=load))
    starts = []
    for index in range(plan.starts):
        tick(f'start-up {index + 1}')
        starts.append([first_bearing(way) for way in (THREE, ONE)])
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

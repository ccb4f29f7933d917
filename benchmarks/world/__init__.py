"""
What happens outside the lab: situations that break what segmenter and locator take for granted.

Each is played as whole frames through both with their defaults, and judged by one rule: found,
near the bound and with a true covariance, or silent with a reason that names the cause.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import as_completed, ProcessPoolExecutor
from multiprocessing import get_context

from benchmarks.world import judge, play, situations
from benchmarks.world.judge import Row
import cv2

__all__ = ['FULL', 'QUICK', 'Row', 'SEED', 'run', 'steps']

Tick = Callable[[str], None]

FULL = 1000  # flashes of a situation
QUICK = 100
SEED = 20_260  # other than those of the tests
WORKERS = 2


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(situations.situations())


def run(count: int, tick: Tick, seed: int = SEED, workers: int = WORKERS) -> list[Row]:
    """
    Play and judge all situations, shared out to so many processes.

    Parameters
    ----------
    count : int
        Flashes of each.
    tick : callable
        Hears which one is done.
    seed : int
        Of all that is random.
    workers : int
        Processes.

    """
    names = list(situations.situations())
    rows: dict[str, Row] = {}
    with ProcessPoolExecutor(
        workers, mp_context=get_context('spawn'), initializer=cv2.setNumThreads, initargs=(1,)
    ) as processes:
        waiting = {processes.submit(look_at, name, count, seed): name for name in names}
        for done in as_completed(waiting):
            name = waiting[done]
            rows[name] = done.result()
            tick(f'world {name}')
    return [rows[name] for name in names]


def look_at(name: str, count: int, seed: int) -> Row:
    """Return the row of one situation."""
    situation = situations.situations()[name]
    return judge.judge(situation, play.play(situation, count, seed))

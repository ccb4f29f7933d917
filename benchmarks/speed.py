"""Fits a second on one core, and microseconds for a single call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median
from time import perf_counter, process_time

from benchmarks.accuracy import sweeps, Tick
from benchmarks.contender import Contender, count_for
from benchmarks.scenes import sample, Scene
from benchmarks.windows import take, Windows

REFERENCE = 'Picasso gaussfit'
PAIRED = ', lit and unlit'  # ends the name of a scene with an unlit window
TEXTURE = 0.02  # of the ambient light in those scenes: some windows gain by the unlit one
SINGLE_CALLS = 100


@dataclass(frozen=True)
class Pace:
    """
    How fast one contender is on one scene.

    Parameters
    ----------
    scene, contender : str
        Names.
    per_second : float
        Fits a second of processor time over a stack, all threads counted, the adapter's
        conversion of the pixels included: what others take of a busy machine does not count.
    single : float
        Seconds of one call for one window, by the clock on the wall.
    ratio : float or None
        per_second over that of Picasso in the same run; None if Picasso is missing.
    count, repeats : int
        Windows in the stack, and repeats of which the median is taken.

    """

    scene: str
    contender: str
    per_second: float
    single: float
    ratio: float | None
    count: int
    repeats: int


def scenes() -> dict[str, Scene]:
    """Return the three named scenes, and the same with an unlit window to each lit one."""
    named = sweeps()['scene']
    paired = {name + PAIRED: replace(each, texture=TEXTURE) for name, each in named.items()}
    return {**named, **paired}


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(scenes())


def run(contenders: Sequence[Contender], count: int, repeats: int, tick: Tick) -> list[Pace]:
    """
    Return the pace of each contender on the named scenes, lit alone and paired.

    Contenders take turns within each repeat, so that a busy machine slows all of them alike.
    """
    paces: list[Pace] = []
    for name, scene in scenes().items():
        tick(f'speed {name}')
        windows = sample(scene, count, 0).windows
        stacks = {c.name: take(windows, count_for(c, count)) for c in contenders}
        one = take(windows, 1)
        batch: dict[str, list[float]] = {c.name: [] for c in contenders}
        single: dict[str, list[float]] = {c.name: [] for c in contenders}
        for contender in contenders:  # compiled here, timed below
            contender.locate(take(windows, 2))
        for _ in range(repeats):
            for contender in contenders:
                call = contender.single or contender.locate
                batch[contender.name].append(
                    _seconds(lambda: contender.locate(stacks[contender.name]), process_time)
                )
                calls = count_for(contender, SINGLE_CALLS)
                single[contender.name].append(
                    median(_seconds(lambda: call(one), perf_counter) for _ in range(calls))
                )
        reference = _rate(REFERENCE, stacks, batch) if REFERENCE in batch else None
        for contender in contenders:
            rate = _rate(contender.name, stacks, batch)
            paces.append(
                Pace(
                    name,
                    contender.name,
                    rate,
                    median(single[contender.name]),
                    None if reference is None else rate / reference,
                    len(stacks[contender.name].lit),
                    repeats,
                )
            )
    return paces


def _rate(name: str, stacks: dict[str, Windows], batch: dict[str, list[float]]) -> float:
    return len(stacks[name].lit) / median(batch[name])


def _seconds(call: Callable[[], object], clock: Callable[[], float]) -> float:
    start = clock()
    call()
    return clock() - start

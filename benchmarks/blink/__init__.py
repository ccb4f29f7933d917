"""
Lights that run free, carry codes and move: found, named, placed, and at what instant.

Frames of true streaks, drawn as design and peer have them, through the segmenter's modes coded
and periodic and the locator.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from benchmarks.blink.peer import SPEEDS
from benchmarks.blink.play import Case, play, Row

__all__ = ['Case', 'FULL', 'QUICK', 'Row', 'Size', 'cases', 'limits', 'run', 'steps']

Tick = Callable[[str], None]
TIMINGS = ('in step', 'free', 'waves')
TURNING = (1.0, 2.0, 5.0, 10.0, 20.0)  # px a frame
CLUTTERED = (2.0, 10.0, 20.0)
FALSE_POINTS = 2  # a frame
FIGURES = ('found', 'visible', 'wrong', 'named', 'nees', 'rms', 'first', 'ms', 'peer')
MANY = 16  # lights
ALMOST = 2.0  # % of the visible frames that may be missed among clutter


@dataclass(frozen=True)
class Size:
    """Frames of a case, and how often it is played with other paths."""

    frames: int
    seeds: int


FULL, QUICK = Size(600, 2), Size(180, 1)


def cases() -> list[Case]:
    """Return all that is played."""
    smooth = [Case(timing, speed=speed) for timing in TIMINGS for speed in SPEEDS]
    turns = [Case(timing, speed=speed, turns=True) for timing in TIMINGS for speed in TURNING]
    clutter = [
        Case(timing, speed=speed, clutter=FALSE_POINTS)
        for timing in TIMINGS for speed in CLUTTERED
    ]
    others = [
        Case('free', lights=1, bits=7, speed=10.0), Case('free', lights=3, bits=7, speed=10.0),
        Case('in step', lights=3, bits=15, speed=20.0),
        Case('free', lights=3, bits=15, speed=20.0),
        Case('in step', lights=MANY, bits=15, speed=5.0),
        Case('free', lights=MANY, bits=15, speed=10.0),
    ]
    return smooth + turns + clutter + others


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(cases())


def run(size: Size, tick: Tick) -> list[Row]:
    """Return a row for each case, the mean over the seeds."""
    rows = []
    for case in cases():
        tick(f'blink {case.timing}, {case.speed:g} px a frame')
        found = [play(case, size.frames, seed) for seed in range(1, size.seeds + 1)]
        rows.append(Row(case, *(
            sum(getattr(row, name) for row in found) / len(found)
            for name in FIGURES
        )))
    return rows


def limits(rows: Sequence[Row]) -> list[tuple[str, float, float, bool, str, str]]:
    """Return name, limit, figure, whether it is a floor, unit and case of each target."""

    def worst(
        name: str, limit: float, some: Sequence[Row], figure: Callable[[Row], float],
        floor: bool, unit: str,
    ) -> tuple[str, float, float, bool, str, str]:
        row = (min if floor else max)(some, key=figure)
        return name, limit, figure(row), floor, unit, label(row.case)

    few = [row for row in rows if row.case.lights <= 3]
    plain = [row for row in few if not row.case.clutter and not row.case.turns]
    turning = [row for row in few if row.case.turns]
    slow = [row for row in turning if row.case.speed <= 10.0]
    fast = [row for row in turning if row.case.speed > 10.0]
    clutter = [row for row in few if row.case.clutter]
    sure = [*plain, *slow, *clutter]
    many = [row for row in rows if row.case.lights == MANY]
    ten = [row for row in plain if row.case.bits == 10 and row.case.timing != 'waves']
    return [
        worst('found of lit frames, smooth', 98.0, plain, lambda row: row.found, True, '%'),
        worst('found, turns to 10 px a frame', 95.0, slow, lambda row: row.found, True, '%'),
        worst('found, turns at 20 px a frame', 75.0, fast, lambda row: row.found, True, '%'),
        worst('missed of the visible, clutter', ALMOST, clutter,
              lambda row: row.visible - row.found, False, '%'),
        worst('wrong places', 0.1, sure, lambda row: row.wrong, False, '%'),
        worst('wrong names', 0.1, sure, lambda row: row.named, False, '%'),
        worst('wrong places or names, turns at 20 px a frame', 1.0, fast,
              lambda row: max(row.wrong, row.named), False, '%'),
        worst('NEES/2, least', 0.9, plain, lambda row: row.nees, True, ''),
        worst('NEES/2, greatest', 1.1, plain, lambda row: row.nees, False, ''),
        ('frames to the first right name, 3 lights of 10 bits', 9.0,
         sorted(row.first for row in ten)[len(ten) // 2], False, '', 'median of the cases'),
        worst('tracker, 3 lights', 0.25, plain, lambda row: row.ms, False, ' ms'),
        worst('tracker, 16 lights', 1.0, many, lambda row: row.ms, False, ' ms'),
    ]


def label(case: Case) -> str:
    """Return a case in words."""
    path = 'turns' if case.turns else 'smooth'
    extra = f', {case.clutter} false' if case.clutter else ''
    bits = '' if case.timing == 'waves' else f' of {case.bits} bits'
    return f'{case.lights}{bits} {case.timing}, {path}, {case.speed:g} px/frame{extra}'

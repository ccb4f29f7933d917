"""How often the flash is found, and how often something else is: on clutter, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed, ProcessPoolExecutor
from dataclasses import dataclass
from math import hypot, isnan, nan
from multiprocessing import get_context

from benchmarks.clutter import clutter, with_target
from benchmarks.finders import FINDERS
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.simulation import Truth
from blob_tracker.types import Frame, Window
import cv2

Tick = Callable[[str], None]

OURS = 'blob_tracker'
SNRS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0)
SIGMAS = (1.0, 2.0, 4.0)  # px
ASKED_SNR = 8.0  # at which the target must be found, and more frames are looked at
FIRST = 12  # frames of a sequence that do not count: in clutter five flashes confirm a light
MAX_PAIR_INTERVAL = 0.1  # s, that of config/tracker.yaml
EMPTY_PARTS = 2  # sequences of a scene without a target
SPACING = 100_000  # indices between sequences: other noise, glints and places
WORKERS = 2


@dataclass(frozen=True)
class Counts:
    """
    How many frames of a sequence, or of several.

    Parameters
    ----------
    curve : int
        Frames of each sequence with a target.
    asked : int
        Frames of each at the SNR that the target names.
    empty : int
        Frames of each scene without a target.
    others : int
        Lit frames of a sequence that the others' ways are given: the first ones that count.

    """

    curve: int
    asked: int
    empty: int
    others: int


FULL = Counts(curve=64, asked=404, empty=8_400, others=15)
QUICK = Counts(curve=16, asked=44, empty=200, others=4)


@dataclass(frozen=True)
class Row:
    """
    One contender on one sequence.

    Parameters
    ----------
    contender, scene : str
        Names.
    sigma, snr : float
        Of the target: px, and its amplitude over the standard deviation of one frame's pixel at
        its peak, before the wall's mean brightness; NaN if there is no target.
    lit, found : int
        Frames that show the target, and those in which it was found: the place within
        2 sigma + 1 px, and the window holds the true place.
    frames, false : int
        Frames looked at, and answers that are not the target.

    """

    contender: str
    scene: str
    sigma: float
    snr: float
    lit: int
    found: int
    frames: int
    false: int


@dataclass(frozen=True)
class Take:
    """
    One sequence of frames: a scene, its target and where it begins.

    Parameters
    ----------
    scene : str
        Name.
    sigma, snr : float
        Of the target; NaN if there is none.
    first, count : int
        First index and number of frames.
    others : int
        Lit frames that the others' ways are given.

    """

    scene: str
    sigma: float
    snr: float
    first: int
    count: int
    others: int


def takes(counts: Counts) -> list[Take]:
    """Return the sequences: each scene with each target, and long ones without any."""
    with_one = [
        Take(
            scene,
            sigma,
            snr,
            SPACING * number,
            counts.asked if snr == ASKED_SNR else counts.curve,
            counts.others,
        )
        for scene in clutter()
        for number, (sigma, snr) in enumerate((s, r) for s in SIGMAS for r in SNRS)
    ]
    without = [
        Take(scene, nan, nan, SPACING * (100 + part), counts.empty // EMPTY_PARTS, 0)
        for scene in clutter()
        for part in range(EMPTY_PARTS)
    ]
    return without + with_one  # the long ones first: the processes end together


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(takes(FULL))


def run(counts: Counts, tick: Tick, workers: int = WORKERS) -> list[Row]:
    """Return the rows of all sequences; they are shared out to so many processes."""
    wanted = takes(counts)
    found: dict[Take, list[Row]] = {}
    with ProcessPoolExecutor(
        workers, mp_context=get_context('spawn'), initializer=cv2.setNumThreads, initargs=(1,)
    ) as processes:
        waiting = {processes.submit(look_at, each): each for each in wanted}
        for done in as_completed(waiting):
            each = waiting[done]
            found[each] = done.result()
            tick(f'detection {each.scene}')
    return [row for each in wanted for row in found[each]]


def look_at(take: Take) -> list[Row]:
    """Return the rows of one sequence: ours and, where there is a target, the others'."""
    setting = clutter()[take.scene]
    scene = setting.scene
    if not isnan(take.snr):
        scene = with_target(scene, take.snr, take.sigma)
    segmenter = Segmenter(
        flash=flash_by_name(
            'alternate',
            max_pair_interval=MAX_PAIR_INTERVAL,
            registration=setting.registration,
        )
    )
    names = [OURS, *(finder.name for finder in FINDERS)]
    lit, found, frames, false = (dict.fromkeys(names, 0) for _ in range(4))
    unlit = None
    for index in range(take.first, take.first + take.count):
        image, truth = scene.frame(index), scene.truth(index)
        window = segmenter.update(Frame(image, scene.stamp_ns(index), scene.sensor.saturation))
        if index < take.first + FIRST:
            unlit = image
            continue
        lit[OURS] += truth.lit
        frames[OURS] += 1
        if window is not None:
            right = truth.lit and holds(window, truth, take.sigma)
            found[OURS] += right
            false[OURS] += not (truth.lit and contains(window, truth))
        if truth.lit and lit[OURS] <= take.others and unlit is not None:
            for finder in FINDERS:
                place = finder.find(image, unlit)
                right = place is not None and near(*place, truth, take.sigma)
                lit[finder.name] += 1
                frames[finder.name] += 1
                found[finder.name] += right
                false[finder.name] += place is not None and not right
        unlit = image
    return [
        Row(
            name, take.scene, take.sigma, take.snr, lit[name], found[name], frames[name],
            false[name],
        )
        for name in names
        if frames[name]
    ]


def share(rows: Sequence[Row]) -> float:
    """Return the part of the lit frames of all rows in which the target was found."""
    lit = sum(row.lit for row in rows)
    return sum(row.found for row in rows) / lit if lit else nan


def near(x: float, y: float, truth: Truth, sigma: float) -> bool:
    """Return whether a place is that of the target, within 2 sigma + 1 px."""
    return hypot(x - truth.x, y - truth.y) <= 2.0 * sigma + 1.0


def contains(window: Window, truth: Truth) -> bool:
    """Return whether the true place lies in one of the window's pixels."""
    height, width = window.lit.shape
    return (
        -0.5 <= truth.x - window.x0 <= width - 0.5 and -0.5 <= truth.y - window.y0 <= height - 0.5
    )


def holds(window: Window, truth: Truth, sigma: float) -> bool:
    """Return whether a window holds the target, and is about it."""
    height, width = window.lit.shape
    middle = window.x0 + 0.5 * (width - 1), window.y0 + 0.5 * (height - 1)
    return contains(window, truth) and near(*middle, truth, sigma)

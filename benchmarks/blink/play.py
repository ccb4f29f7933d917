"""Lights through segmenter and locator, frame by frame, against the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import hypot, nan
from time import process_time

from benchmarks.blink import peer
from benchmarks.blink.lights import (
    codes, EXPOSURE, FREE_RATE, HEIGHT, Light, lights, patterns, RATE, Truth, truth, WIDTH,
)
from benchmarks.blink.pixels import add, frame as picture
from benchmarks.blink.points import LEAST_SHARE, NOISE, PEAK
from blob_tracker.blinking import Pattern
from blob_tracker.location import Locator
from blob_tracker.segmentation import Segmenter, Sighting
from blob_tracker.segmentation.blink import Blink
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.types import Frame, LocationError, SensorNoise
import numpy as np

RIGHT_PX, WRONG_PX = 2.0, 5.0  # px from the light: found, and a wrong place
WAVE_SETTLED = 30  # frames that do not count; of codes it is three lengths
HIDDEN = 0.02  # of the lit frames, in a scene with clutter
# Of a pixel: the frames are drawn without shot noise.
CAMERA = SensorNoise(gain=1e6, read_noise=NOISE)


@dataclass(frozen=True)
class Case:
    """
    What is played.

    Parameters
    ----------
    timing : str
        'in step', 'free' or 'waves'.
    lights, bits : int
        How many, and of each code.
    speed : float
        At the top, px a frame.
    turns : bool
        Whether they turn suddenly; else their paths are sinusoids.
    clutter : int
        False points in each frame.

    """

    timing: str
    lights: int = 3
    bits: int = 10
    speed: float = 0.0
    turns: bool = False
    clutter: int = 0


@dataclass(frozen=True)
class Row:
    """
    What came of a case.

    Parameters
    ----------
    case : Case
        What was played.
    found, visible : float
        Lit frames with the right name within 2 px of the light, and those in which nothing hid
        it, %.
    wrong, named : float
        Lit frames' worth of places beyond 5 px from the light, and of those at another light, %.
    nees : float
        Of the places at their stamps, over 2: 1 where the covariance is true.
    rms : float
        Of them, px.
    first : float
        Frames until a light has its name, the median.
    ms : float
        Of the tracker for a frame, beside the search, the median.
    peer : float
        What AMI finds, %.

    """

    case: Case
    found: float
    visible: float
    wrong: float
    named: float
    nees: float
    rms: float
    first: float
    ms: float
    peer: float


class Timed(Blink):
    """The mode, which notes how long the tracker takes."""

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        begun = process_time()
        chosen = super().choose(contrast, candidates)
        self.seconds = process_time() - begun
        return chosen


@dataclass
class _Count:
    lit: int = 0
    visible: int = 0
    found: int = 0
    wrong: int = 0
    named: int = 0
    squares: list[float] = field(default_factory=list)
    away: list[float] = field(default_factory=list)
    first: dict[str, int] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)


def play(case: Case, frames: int, seed: int) -> Row:
    """Return the row of so many frames of a case."""
    random = np.random.default_rng([
        seed, case.lights, case.bits, round(10 * case.speed), case.turns, case.clutter,
        *case.timing.encode(),
    ])
    known = patterns(case.timing, case.lights, case.bits)
    there = lights(case.timing, known, case.speed, case.turns, frames / RATE + 1.0, random)
    flash = _flash(case, known)
    segmenter, locator = Segmenter(flash=flash), Locator()
    settled = WAVE_SETTLED if case.timing == 'waves' else 3 * case.bits
    count = _Count()
    for index in range(frames):
        time = index / RATE
        hidden = [bool(case.clutter) and random.uniform() < HIDDEN for _ in there]
        image = _image(there, hidden, case.clutter, time, random)
        sightings = segmenter.sightings(Frame(image, round(1e9 * time), 255))
        seen = [truth(light, time) for light in there]
        if index >= settled:
            for each, away in zip(seen, hidden):
                lit = each is not None and each.share >= LEAST_SHARE
                count.lit += lit
                count.visible += lit and not away
            count.seconds.append(getattr(flash, 'seconds', nan))
        _judge(sightings, locator, there, seen, index, index >= settled, count)
    first = [count.first.get(each.name, frames) for each in known]
    part = 100.0 / max(count.lit, 1)
    return Row(
        case, part * count.found, part * count.visible, part * count.wrong, part * count.named,
        float(np.mean(count.squares)) if count.squares else nan,
        float(np.sqrt(np.mean(np.square(count.away)))) if count.away else nan,
        float(np.median(first)), 1e3 * float(np.median(count.seconds)),
        peer.found(case.timing, case.speed, case.turns, case.lights, case.bits, case.clutter),
    )


def _flash(case: Case, known: Sequence[Pattern]) -> Timed:
    if case.timing == 'waves':
        return Timed(frequencies={each.name: 1.0 / each.period for each in known},
                     exposure=EXPOSURE)
    names = [each.name for each in known]
    return Timed(
        codes=dict(zip(names, codes(case.lights, case.bits))),
        bits_per_second=RATE if case.timing == 'in step' else FREE_RATE, exposure=EXPOSURE,
    )


def _image(
    there: Sequence[Light], hidden: Sequence[bool], clutter: int, time: float,
    random: np.random.Generator,
) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return the frame at a time, with points of no light in it."""
    extra = np.zeros((HEIGHT, WIDTH), np.float32)
    for _ in range(clutter):
        place = random.uniform([8.0, 8.0], [WIDTH - 8.0, HEIGHT - 8.0])
        add(extra, place[None], PEAK * random.uniform(2 * LEAST_SHARE, 1.0))
    return picture(there, hidden, time, random, extra)


def _judge(
    sightings: Sequence[Sighting], locator: Locator, there: Sequence[Light],
    seen: Sequence[Truth | None], index: int, settled: bool, count: _Count,
) -> None:
    """Hold the sightings of a frame against the truth at their stamps."""
    names = [light.pattern.name for light in there]
    for name, window in sightings:
        light = there[names.index(name)]
        try:
            location = locator.locate(window, noise=CAMERA, light=name)
        except LocationError:
            continue
        time = np.array(window.stamp_ns / 1e9)
        error = np.array([location.x, location.y]) - light.path.at(time)
        away = hypot(*error) if seen[names.index(name)] is not None else np.inf
        if away < RIGHT_PX:
            count.first.setdefault(name, index + 1)
        if not settled:
            continue
        shown = seen[names.index(name)]
        if away < RIGHT_PX:
            count.found += shown is not None and shown.share >= LEAST_SHARE
        else:
            count.wrong += away > WRONG_PX
            count.named += any(
                each is not None and other is not light
                and hypot(location.x - each.x, location.y - each.y) < RIGHT_PX
                for each, other in zip(seen, there)
            )
        if away < WRONG_PX:
            count.squares.append(float(error @ np.linalg.solve(location.covariance, error)) / 2)
            count.away.append(away)

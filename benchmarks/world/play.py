"""A situation through segmenter and locator with their defaults, frame by frame."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from math import hypot, nan
import re

from benchmarks.world.bound import bound
from benchmarks.world.situation import Floats, FULL_SCALE, RATE, Shot, Situation
from blob_tracker.location.locator import Locator
from blob_tracker.location.noise_check import NoiseCheck
from blob_tracker.segmentation import FrameError, Segmenter
from blob_tracker.types import Frame, Location, LocationError
import numpy as np

METHOD = 'maximum_likelihood'  # the default
FIRST = 40  # frames that do not count: a light is confirmed by then
BOUNDS = 24  # frames over which the bound is averaged
NUMBER = re.compile(r'\d+(\.\d+)?')


@dataclass
class Played:
    """
    What came of a situation.

    Parameters
    ----------
    frames, lit, found : int
        Frames judged, those in which the light had to be found, and those in which it was.
    errors : list of (2,) arrays
        Of each bearing, px; NaN where there was nothing to be found.
    covariances : list of (2, 2) arrays
        Of each bearing, px^2.
    chi2 : list of float
        Of each bearing.
    bounds : list of (2, 2) arrays
        Of some lit frames, px^2.
    said : Counter
        Warnings of all frames, and the reasons of those that should have had a bearing; without
        their numbers.
    words : dict
        The first sentence of each, with its numbers.

    """

    frames: int = 0
    lit: int = 0
    found: int = 0
    errors: list[Floats] = field(default_factory=list)
    covariances: list[Floats] = field(default_factory=list)
    chi2: list[float] = field(default_factory=list)
    bounds: list[Floats] = field(default_factory=list)
    said: Counter[str] = field(default_factory=Counter)
    words: dict[str, str] = field(default_factory=dict)

    def hear(self, sentence: str) -> None:
        """Count a sentence, whatever its numbers."""
        kind = NUMBER.sub('#', sentence)
        self.said[kind] += 1
        self.words.setdefault(kind, sentence)


def play(situation: Situation, count: int, seed: int) -> Played:
    """
    Play a situation until `count` flashes have been judged.

    Parameters
    ----------
    situation : Situation
        Frames and truth.
    count : int
        Flashes, two frames each, after the first 40 frames.
    seed : int
        Of all that is random in it; each situation draws its own numbers from it.

    """
    random = np.random.default_rng([seed, situation.number, *situation.name.encode()])
    segmenter, locator = Segmenter(), Locator(METHOD)
    noise = NoiseCheck(situation.noise)
    played = Played()
    every = max(1, count // BOUNDS)
    for index, shot in enumerate(situation.frames(FIRST + 2 * count, random)):
        stamp_ns = round(index * 1e9 / RATE)
        frame = Frame(
            shot.image, stamp_ns, FULL_SCALE, layout=situation.layout,
            quantisation=shot.quantisation,
        )
        location, reason, warnings = _look(segmenter, locator, frame, noise)
        if index < FIRST or not shot.judged:
            continue
        played.frames += 1
        played.lit += shot.lit
        if location is not None:
            played.found += shot.lit
            played.errors.append(_error(location, shot))
            played.covariances.append(location.covariance)
            played.chi2.append(location.chi2)
        elif shot.on and reason:
            played.hear(reason)
        for warning in warnings:
            played.hear(warning)
        if shot.lit and shot.model is not None and played.lit % every == 0:
            played.bounds.append(bound(shot.model))
    return played


def _look(
    segmenter: Segmenter, locator: Locator, frame: Frame, noise: NoiseCheck
) -> tuple[Location | None, str, list[str]]:
    """Return the location, or the reason why there is none, and what was warned of."""
    location, reason = None, ''
    try:
        window = segmenter.update(frame)
        reason = segmenter.reason
        if window is not None:
            location = locator.locate(window, noise=noise.noise)
            location = noise.doubted(window, location)
            noise.add(window, location)
    except (FrameError, LocationError) as error:
        reason = str(error)
    warnings = [*segmenter.warnings]
    if location is not None:
        warnings += [location.warning, noise.warning]
    return location, reason, [warning for warning in warnings if warning]


def _error(location: Location, shot: Shot) -> Floats:
    """Return the error, px, from the nearest place that is right."""
    if shot.x != shot.x:
        return np.array([nan, nan])
    places = [(shot.x, shot.y)] + ([shot.also] if shot.also is not None else [])
    x, y = min(places, key=lambda place: hypot(location.x - place[0], location.y - place[1]))
    return np.array([location.x - x, location.y - y])

"""Frames that are taken in one call tell the same, to the bit, as step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from blob_tracker.segmentation import at_once, flash_memory, FrameError, Segmenter
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame, Pixels
import numpy as np
from numpy.typing import NDArray
import pytest

RATE, FRAMES = 60.0, 180  # Hz
Numbers = NDArray[np.float64]
Odd = Callable[[int, Numbers], Numbers]
SCENE = flashing_light(width=160, height=120, rate=RATE, period=8.0)
IMAGES = [SCENE.frame(index) for index in range(FRAMES)]


def glint(index: int, image: Numbers) -> Numbers:
    """Light up something else now and then."""
    if index in (90, 121):
        image[40:43, index % 120:index % 120 + 3] = 220.0
    return image


def hidden(index: int, image: Numbers) -> Numbers:
    """Hide the light for ten frames, and for one."""
    return np.rint(20.0 + image % 2.0) if 100 <= index < 110 or index == 151 else image


def late(index: int, image: Numbers) -> Numbers:
    """Show nothing before the light, nor while the scene flashes; then it is cut by the edge."""
    if index < 60:
        dark = IMAGES[(2 * index + 1) % FRAMES].astype(float)
        return dark + 15.0 * (index % 2) * (20 <= index < 30)
    return np.roll(image, -80, axis=1) if index < 70 else image


def lamp(index: int, image: Numbers) -> Numbers:
    """Light up something else in every third frame, before the light and beside it."""
    image = IMAGES[(2 * index + 1) % FRAMES].astype(float) if index < 60 else image
    if index % 3 == 0:
        image[20:24, 30:34] += 90.0
    return image


ODD: dict[str, Odd] = {
    'as ever': lambda index, image: image,
    'late': late,
    'lamp': lamp,
    'glint': glint,
    'hidden': hidden,
    'a lamp goes on': lambda index, image: image + 40.0 * (index // 30 % 2),
    'clipped': lambda index, image: 3.0 * image if index > 120 else image,
    'clipped at 180 DN': lambda index, image: np.minimum(1.5 * image, 180.0),
    'black': lambda index, image: image * (index % 50 > 2),
    'leaps': lambda index, image: np.roll(image, 30 * (index // 110), axis=1),
    'still': lambda index, image: IMAGES[index % 4].astype(float),
    'comes twice': lambda index, image: IMAGES[index - (index == 121)].astype(float),
}


def told(segmenter: Segmenter, frame: Frame) -> list[Any]:
    """Return all that a segmenter tells of a frame, arrays as lists."""
    try:
        sightings = segmenter.sightings(frame)
    except FrameError as error:
        return [str(error)]
    found: list[Any] = [
        segmenter.reason, segmenter.warnings, segmenter.finding, segmenter.repeated_frames,
        segmenter.flash.locked,
    ]
    for name, window in sightings:
        glimpse = window.glimpse
        found += [
            name, window.lit.tolist(), window.unlit is not None and window.unlit.tolist(),
            None if glimpse is None else glimpse.numbers.tolist(),
            replace(window, lit=None, unlit=None, glimpse=None),
        ]
    pair, seen = segmenter.unlit_pair, segmenter.detections
    found.append(pair is not None and [each.tolist() for each in pair])
    if seen is not None:
        found += [seen.lit.tolist(), *seen[2:5], tuple(seen.candidates), *seen[6:]]
    return found


@pytest.mark.parametrize('kind, fields', [
    (np.uint8, {}),
    (np.uint16, {'line_time_ns': 2e4, 'exposure_ns': 8_000_000, 'x0': 4, 'binning': (2, 2)}),
])
@pytest.mark.parametrize('odd', ODD)
def test_all_is_as_step_by_step(
    odd: str, kind: type, fields: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows, reasons, warnings and all that is seen; and many frames are taken at once."""
    outcomes = []
    pair_at_once = at_once.pair_at_once

    def noted(*given: Any) -> Any:
        outcomes.append(pair_at_once(*given))
        return outcomes[-1]

    monkeypatch.setattr(flash_memory, 'pair_at_once', noted)
    mask = np.ones((120, 160), np.uint8)
    mask[:, :8] = 0
    quick, slow = Segmenter(mask=mask), Segmenter(mask=mask)
    monkeypatch.setattr(slow, '_asked', None)
    for index, image in enumerate(IMAGES):
        pixels: Pixels = np.clip(ODD[odd](index, image.astype(float)), 0.0, 255.0).astype(kind)
        frame = Frame(pixels, SCENE.stamp_ns(index), 255, **fields)
        assert told(quick, frame) == told(slow, frame), index
    many = sum(outcome >= at_once.QUIET for outcome, *_ in outcomes)
    assert many > (0.5 * FRAMES if odd == 'as ever' else 20)


@pytest.mark.parametrize('first', [2, 20])
def test_a_light_that_appears_is_taken_at_once(
    first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No frame of an empty scene takes more, nor one in which a light lights up, or is taken."""
    outcomes = []
    pair_at_once = at_once.pair_at_once

    def noted(*given: Any) -> Any:
        found = pair_at_once(*given)
        outcomes.append(found[0])
        return found

    monkeypatch.setattr(flash_memory, 'pair_at_once', noted)
    segmenter, windows = Segmenter(), []
    for index in range(first + 6):
        dark = index < first
        image = IMAGES[2 * index + 1] if dark else IMAGES[index]
        windows.append(segmenter.update(Frame(image, SCENE.stamp_ns(index), 255)))
        if windows[-1] is not None:
            break
    quiet = first - 1
    assert outcomes[:quiet] == [at_once.QUIET] * quiet
    assert at_once.UNUSUAL not in outcomes and at_once.SEARCHED not in outcomes
    assert outcomes[-1] == at_once.SHOWS_IT
    # A first light that is the only one is trusted; a later one takes more flashes than one.
    assert (at_once.LIT_UP in outcomes) == (first > 2)

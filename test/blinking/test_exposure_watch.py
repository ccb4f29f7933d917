"""An exposure that is told wrongly is noticed, one that is about right is not doubted."""

from __future__ import annotations

from blob_tracker.blinking import code, Pattern, wave
from blob_tracker.blinking.exposure_watch import (
    CLOSE_FRAMES, ExposureWatch, SELDOM_FRAMES, TURN_FRAMES,
)
from blob_tracker.blinking.patterns import look
import numpy as np
import pytest

INTERVAL = 1.0 / 60.0
FULL, NOISE = 1400.0, 10.0  # DN px^2
FRAMES = 200
WAVE, CODE = wave('w', 13.7, 0.5), code('c', '1101000110', 41.3)
PHASES = 20_000  # of a period


def ratios(told: float, true: float, pattern: Pattern, fade: float = 0.0) -> list[float]:
    """Return what is said after each frame; both exposures are parts of the frame interval."""
    random = np.random.default_rng(3)
    watch = ExposureWatch([pattern], INTERVAL, told * INTERVAL)
    shares, _ = look(pattern, PHASES, (true + fade) * INTERVAL)
    track = np.array([FULL, 0.01, 1e-4, 0.0, 0.0, 0.0])
    found = []
    for frame in range(FRAMES):
        share = shares[int((frame + 0.5) * INTERVAL / pattern.period % 1.0 * PHASES)]
        flux = share * FULL + NOISE * random.standard_normal()
        watch.add(
            0, float(frame), (flux, NOISE) if share > 0.05 else None, track, 0.05 * FULL
        )
        found.append(watch.ratio)
    return found


@pytest.mark.parametrize('pattern', [WAVE, CODE])
@pytest.mark.parametrize('told, true', [(0.25, 0.75), (0.25, 0.5), (0.7, 0.25)])
def test_a_wrong_exposure_is_noticed(told: float, true: float, pattern: Pattern) -> None:
    """Within three seconds, and by about as much as it is wrong: the steps are of 1.4."""
    ratio = ratios(told, true, pattern)[-1]
    assert true / told / 1.5 < ratio < 1.5 * true / told


@pytest.mark.parametrize('pattern', [WAVE, CODE])
@pytest.mark.parametrize('told, true', [(0.25, 0.25), (0.5, 0.5), (0.75, 0.75), (0.5, 0.55)])
def test_what_is_about_right_is_not_doubted(
    told: float, true: float, pattern: Pattern
) -> None:
    """In no frame."""
    assert set(ratios(told, true, pattern)) == {1.0}


def test_a_light_that_fades_is_noticed() -> None:
    """Over a frame interval: as by a longer exposure."""
    assert ratios(0.3, 0.3, WAVE, fade=0.5)[-1] > 1.5


def test_a_light_that_is_never_partly_lit_tells_nothing() -> None:
    """It is in step."""
    assert set(ratios(0.25, 0.25, code('s', '110', 60.0, 1))) == {1.0}


def looks(watch: ExposureWatch, sure: list[int], frames: int) -> list[int]:
    """Return which light was looked at in the frames in which one was."""
    names = [watch.whose_turn(sure) for _ in range(frames) if watch.is_due()]
    return [name for name in names if name is not None]


def test_a_light_is_watched_closely_and_then_now_and_then() -> None:
    """The exposure does not change: 3 % of the segmenter's time are enough for it."""
    track = np.array([FULL, 0.01, 1e-4, 0.0, 0.0, 0.0])
    watch, seen = ExposureWatch([WAVE], INTERVAL, 0.25 * INTERVAL), []
    shares, _ = look(WAVE, PHASES, 0.25 * INTERVAL)
    for frame in range(CLOSE_FRAMES + 10 * SELDOM_FRAMES):
        if watch.is_due() and watch.whose_turn([0]) == 0:
            share = shares[int((frame + 0.5) * INTERVAL / WAVE.period % 1.0 * PHASES)]
            flux = (share * FULL, NOISE) if share > 0.05 else None
            watch.add(0, float(frame), flux, track, 0.05 * FULL)
            seen.append(frame)
    assert seen[:CLOSE_FRAMES] == list(range(CLOSE_FRAMES))
    assert len(seen) == pytest.approx(CLOSE_FRAMES + 10, abs=1)


def test_lights_take_turns_but_for_those_in_step() -> None:
    """What is in step has the same shares whatever the exposure."""
    patterns = [WAVE, code('s', '110', 60.0, 1), CODE]
    watch = ExposureWatch(patterns, INTERVAL, 0.25 * INTERVAL)
    assert looks(watch, [1], 10) == []
    found = looks(watch, [0, 1, 2], 2 * TURN_FRAMES)
    assert found == sorted(found) and set(found) == {0, 2}


def test_a_light_that_is_lost_gives_its_turn_to_another() -> None:
    """At once."""
    watch = ExposureWatch([WAVE, CODE], INTERVAL, 0.25 * INTERVAL)
    assert looks(watch, [0, 1], 1) == [0]
    assert looks(watch, [1], 1) == [1]

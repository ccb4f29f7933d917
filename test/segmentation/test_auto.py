"""A light of which nothing is known is followed after a few seconds, whatever its pattern."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.auto import Auto, TRY_S, WATCH_S
from blob_tracker.simulation import always, coded, in_step, Light, periodic, Scene
from blob_tracker.simulation.waveforms import Waveform
from blob_tracker.types import Frame
import numpy as np
import pytest

RATE = 60.0
PLACE = 40.2, 30.7
DECIDED = round(RATE * (TRY_S + WATCH_S)) + 10  # frames, after which a light is followed


def scene(*waveforms: Waveform) -> Scene:
    """Return a scene of lights, the first of them at PLACE."""
    lights = [
        Light(PLACE[0] + 50.0 * index, PLACE[1], 2.0, 120.0 - 40.0 * index, each)
        for index, each in enumerate(waveforms)
    ]
    return Scene(
        elements=lights, width=128, height=64, rate=RATE, exposure=0.5, texture=0.0
    )


class Played:
    """Feed frames; note in which there was a window, each about the light at PLACE."""

    def __init__(self) -> None:
        self.segmenter = Segmenter(flash=Auto(exposure=0.5 / RATE))
        self.index = 0

    def __call__(self, before: Scene, count: int) -> list[int]:
        found = []
        for _ in range(count):
            frame = Frame(before.frame(self.index), before.stamp_ns(self.index), 255)
            window = self.segmenter.update(frame)
            if window is not None:
                middle = np.array(window.lit.shape[::-1]) / 2 - 0.5 + [window.x0, window.y0]
                assert np.hypot(*(middle - PLACE)) < 2.0
                found.append(self.index)
            self.index += 1
        return found


def test_a_light_in_every_other_frame_is_followed_at_once() -> None:
    """As by the mode alternate: from the third frame on, and no longer watched."""
    play = Played()
    found = play(scene(in_step(RATE)), 150)
    assert found[0] < 4 and len(found) >= 73
    assert play.segmenter.finding == 'on in every other frame; set flash.mode alternate'


def test_a_light_that_was_found_is_waited_for() -> None:
    """Hidden for a quarter of each second it is followed on, and not watched."""
    play = Played()
    play(scene(in_step(RATE)), 70)
    flash = in_step(RATE)
    hidden = scene(lambda times: flash(times) * (times % 1.0 > 0.25))
    found = play(hidden, 240)
    assert len(found) >= 0.9 * 0.5 * 0.75 * 240 - 4 * 3  # each time it is found after 3 frames
    assert not play.segmenter.reason.startswith('watching')


def test_a_watch_that_is_full_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a high frame rate it keeps fewer seconds than it would watch for."""
    monkeypatch.setattr('blob_tracker.segmentation.auto.MOST_FRAMES', 60)
    play = Played()
    play(scene(periodic(10.3, 0.5)), 90)
    assert play.segmenter.reason.endswith('s of 0.98')
    play(scene(periodic(10.3, 0.5)), 50)
    assert len(play(scene(periodic(10.3, 0.5)), 60)) >= 23


@pytest.mark.parametrize('waveform, words', [
    (periodic(10.3, 0.5), 'set flash.mode periodic, flash.frequency 10.3, flash.duty 0.5'),
    (coded('1101000', 1.0 / 59.7), "set flash.mode coded, flash.codes 'light:1101000'"),
])
def test_another_one_is_watched_and_then_followed(waveform: Waveform, words: str) -> None:
    """In nearly all of its lit frames, 26 or more of 60; it says what to set."""
    play = Played()
    play(scene(waveform), 90)
    assert play.segmenter.reason.startswith('watching what blinks: 0.')
    assert play.segmenter.finding == ''
    play(scene(waveform), DECIDED + 20 - 90)
    found = play(scene(waveform), 60)
    assert len(found) >= 23
    assert words in play.segmenter.finding


def test_the_brightest_of_several_is_followed() -> None:
    """The others are named in a warning."""
    play = Played()
    before = scene(periodic(10.3, 0.5), periodic(6.1, 0.5))
    play(before, DECIDED)
    assert play(before, 40)
    warning, = play.segmenter.warnings
    assert '2 lights blink' in warning and 'wave of 6.1' in warning


@pytest.mark.parametrize('waveform, reason', [
    (always, 'watched for 3.0 s: nothing blinks'),
    (lambda times: np.abs(np.sin(2.0 * np.pi * 50.0 * times)), 'lamp of 100 Hz'),
])
def test_lamps_are_not_followed(waveform: Waveform, reason: str) -> None:
    """Alternate goes on, with what was seen in its reason."""
    play = Played()
    assert play(scene(waveform), DECIDED) == []
    assert reason in play.segmenter.reason
    assert play.segmenter.finding == ''


def test_a_light_that_is_lost_is_looked_for_again() -> None:
    """With another pattern: dark for a while, then it blinks in every other frame."""
    play = Played()
    play(scene(periodic(10.3, 0.5)), DECIDED)
    assert play(scene(periodic(10.3, 0.5)), 30)
    play(scene(lambda times: 0.0 * times), round(6.5 * RATE))
    assert len(play(scene(in_step(RATE)), round(6.0 * RATE))) > RATE

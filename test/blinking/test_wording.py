"""A light in words has its numbers with their sigmas."""

from __future__ import annotations

from typing import Any

from blob_tracker.blinking.paths import Path
from blob_tracker.blinking.recognition import Brightness, Rhythm
from blob_tracker.blinking.survey import Light
from blob_tracker.blinking.wording import describe, with_sigma
import numpy as np
import pytest

NONE = np.zeros(0)
NOWHERE = Path(np.zeros(0, int), NONE, NONE, NONE, NONE, np.zeros(0, int))
DARK = Brightness(NONE, NONE, NONE, 1.0)


def light(mains: float = 0.0, **rhythm: Any) -> Light:
    """Return a light of this rhythm, at 60 frames/s."""
    return Light(NOWHERE, DARK, Rhythm(**rhythm), 60.0, mains=mains)


@pytest.mark.parametrize('seen, words', [
    (light(kind='wave', period=10.0, period_sigma=1e-3, duty=0.5, duty_sigma=0.01),
     'wave of 6.00000 ± 0.00060 Hz, on for 0.500 ± 0.010 of it'),
    (light(kind='wave', period=2.0, period_sigma=1e-4, duty=0.5),
     'on in every other frame, 30.0000 ± 0.0015 Hz'),
    (light(kind='code', period=14.0, period_sigma=1e-3, bits='1101000', duty=3 / 7),
     'code 1101000, in step, 2 frames a bit, 30.0000 ± 0.0021 bits/s, on for 0.4286 of it'),
    (light(kind='code', period=7.0352, period_sigma=1e-3, bits='1101000', duty=3 / 7),
     'code 1101000, free-running, 59.6998 ± 0.0085 bits/s, on for 0.4286 of it'),
    (light(kind='irregular', changes=4), 'blinks (4 changes) without a period'),
    (light(kind='short', changes=4), 'blinks (4 changes), but not for long enough to say how'),
    (light(kind='modulated', period=3.0, mains=100.0), 'lamp of 100 Hz, seen at 20 Hz'),
    (light(kind='modulated', period=4.0), 'never dark, brighter and darker at 15 Hz'),
])
def test_lights_in_words(seen: Light, words: str) -> None:
    """One sentence for each kind."""
    assert describe(seen) == words


def test_two_digits_of_the_sigma_are_given() -> None:
    """None where there is no sigma."""
    assert with_sigma(3.0, 0.0) == '3'
    assert with_sigma(123.456, 12.0) == '123 ± 12'
    assert with_sigma(0.123456, 0.00123) == '0.1235 ± 0.0012'

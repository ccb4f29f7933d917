"""Which parameters track the lights that were seen, and what is said where none do."""

from __future__ import annotations

from typing import Any

from blob_tracker.blinking.paths import Path
from blob_tracker.blinking.recognition import Brightness, Rhythm
from blob_tracker.blinking.survey import Light
from blob_tracker.calibration.flash import (
    clock_error, enough, flash_settings, notes,
)
import numpy as np
import pytest

RATE = 60.0
PLACE = Path(*(np.zeros(2, int), np.zeros(2), np.zeros(2), np.ones(2), np.ones(2)),
             np.zeros(2, int))
SHINE = Brightness(np.arange(6.0), np.array([1.0, 0.0, 1.0, 1.0, 0.0, 1.0]), np.ones(6), 0.1)


def wave(frequency: float, duty: float = 0.5, sigma: float = 1e-4, **more: Any) -> Light:
    """Return a wave of so many Hz, whose period has a relative sigma."""
    period = RATE / frequency
    rhythm = Rhythm('wave', period, sigma * period, duty, 0.01)
    return Light(PLACE, SHINE, rhythm, RATE, **more)


def code(bits: str, rate: float, sigma: float = 1e-4) -> Light:
    """Return a code of so many bits a second."""
    period = len(bits) * RATE / rate
    return Light(PLACE, SHINE, Rhythm('code', period, sigma * period, 0.4, bits=bits), RATE)


def other(kind: str, period: float = 0.0, **more: Any) -> Light:
    """Return a light that cannot be tracked."""
    return Light(PLACE, SHINE, Rhythm(kind, period, 1e-4 * period, changes=4), RATE, **more)


def test_waves() -> None:
    """Each by its name; a lamp on the mains is left out."""
    found = flash_settings([wave(6.0), wave(20.0, mains=100.0), wave(13.7, 0.48)], 0.004)
    assert found.values == {
        'flash.mode': 'periodic', 'flash.frequencies': 'light_1:6,light_3:13.7',
        'flash.duty': 0.49, 'flash.exposure': 0.004,
    }
    assert found.named == ('light_1', '', 'light_3') and not found.notes


def test_codes_in_step_and_free() -> None:
    """In step only where that is known to 0.1 %; waves may stand beside them."""
    assert flash_settings([code('1101000', 30.0)], 0.0).values == {
        'flash.mode': 'coded', 'flash.codes': 'light_1:1101000', 'flash.frames_per_bit': 2,
    }
    for light in (code('1101000', 59.7), code('1101000', 59.7, 5e-3)):
        found = flash_settings([light, wave(6.0)], 0.0).values
        assert found['flash.bits_per_second'] == 59.7 and 'flash.frames_per_bit' not in found
        assert found['flash.mode'] == 'coded' and found['flash.frequencies'] == 'light_2:6'


def test_every_other_frame() -> None:
    """One such light is what the default is for; two cannot be told apart."""
    assert flash_settings([wave(30.0)], 0.0).values == {'flash.mode': 'alternate'}
    two = flash_settings([wave(30.0), wave(30.0)], 0.0)
    assert two.values == {'flash.mode': 'alternate'} and 'give them codes' in two.notes[0]
    beside = flash_settings([wave(30.0), wave(6.0)], 0.0)
    assert beside.values['flash.frequency'] == 6.0 and 'alternate' in beside.notes[0]


def test_one_that_drifts_is_for_alternate_as_well() -> None:
    """Within 1 % of half the frame rate; by how much it drifts is said."""
    light = wave(29.9, sigma=1e-5)
    found = flash_settings([light, wave(28.0)], 0.0)
    assert found.values == {'flash.mode': 'alternate'}
    assert 'light 2 is left out' in found.notes[0]
    note, = notes(light)
    assert 'half the frame rate by about 3300 ppm' in note
    assert notes(wave(30.0, sigma=1e-5)) == []
    assert not wave(29.5, sigma=1e-5).alternates


def test_a_light_that_is_alone() -> None:
    """A wave has no name; a code has one, which locator and tracker are told."""
    found = flash_settings([wave(6.0), other('irregular')], 0.0)
    assert found.values == {'flash.mode': 'periodic', 'flash.frequency': 6.0, 'flash.duty': 0.5}
    assert found.named == ('', '') and found.lights == ''
    assert flash_settings([code('1101000', 30.0)], 0.0).lights == 'light_1'
    assert flash_settings([code('1101000', 30.0), wave(6.0)], 0.0).lights == 'light_1,light_2'


@pytest.mark.parametrize('faulty', [
    wave(28.0), wave(10.1), code('1010001', 60.0), code('1110100', 30.0), wave(0.7),
])
def test_one_that_a_mode_refuses_does_not_silence_the_others(faulty: Light) -> None:
    """It is left out."""
    good = [wave(10.0), code('1101000', 60.0)]
    found, alone = flash_settings([*good, faulty], 0.0), flash_settings(good, 0.0)
    assert found.values == alone.values and found.named == (*alone.named, '')
    assert 'light 3 is left out' in found.notes[0] and not alone.notes


def test_a_duty_beyond_what_may_be_set() -> None:
    """Is clipped, and said."""
    found = flash_settings([wave(6.0, 0.02)], 0.0)
    assert found.values['flash.duty'] == 0.05
    assert 'on for 0.020 of its period: flash.duty may be 0.05 to 0.95' in found.notes[0]


def test_nothing_to_set() -> None:
    """Where no light keeps a rate of its own."""
    lights = [other('irregular'), other('short'), wave(20.0, mains=100.0)]
    assert flash_settings(lights, 0.0).values == {}


@pytest.mark.parametrize('lights, sentence', [
    ([code('1101000', 60.0), code('1010001', 60.0)], 'one code begun at another bit'),
    ([code('1101000', 60.0), code('1110100', 30.0)], '30.00 to 60.00 bits a second'),
    ([wave(10.0), wave(10.1)], 'clocks are off by 1 %'),
    ([wave(6.0, 0.2), wave(10.0, 0.6)], 'on for 0.20 to 0.60 of their periods'),
    ([wave(28.0)], '60.0 frames a second show 1.2 to 27.0 Hz'),
])
def test_what_speaks_against_them(lights: list[Light], sentence: str) -> None:
    """Together or each, they cannot be told or followed."""
    assert any(sentence in note for note in flash_settings(lights, 0.0).notes)


def test_clocks_are_held_against_something() -> None:
    """Codes against the frames, waves against a round number where that is known."""
    against, error, sigma = clock_error(code('1101000', 59.7))
    assert (against, round(error), round(sigma)) == ('1 frame a bit', -5000, 100)
    against, error, _ = clock_error(wave(13.702))
    assert against == '13.7 Hz' and error == pytest.approx(146.0, abs=0.5)
    assert clock_error(wave(13.7, sigma=0.01)) is None
    assert clock_error(code('1101000', 53.0)) is None


@pytest.mark.parametrize('light, sentence', [
    (other('short'), 'did not come twice: record 3 s'),
    (other('irregular'), 'does not keep a rate'),
    (wave(20.0, mains=100.0), 'switch the lamps off'),
    (wave(10.0, aliases=(50.0, 70.0)), 'do not tell 10.00 Hz from 50.0, 70.0 Hz'),
    (code('1101000', 60.0, 5e-3), 'flash.bits_per_second tracks it either way'),
])
def test_what_a_newcomer_should_know(light: Light, sentence: str) -> None:
    """Of one light."""
    assert sentence in ' '.join(notes(light))


def test_how_long_is_enough() -> None:
    """Three periods of the slowest wave."""
    assert enough(1.0, 60.0) == 2.0 and enough(5.0, 60.0) == 0.0

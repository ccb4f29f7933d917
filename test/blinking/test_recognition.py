"""Waves and codes are told by their brightness, with sigmas that hold; noise is not."""

from __future__ import annotations

from blob_tracker.blinking.patterns import code, look, Pattern, wave
from blob_tracker.blinking.recognition import (
    aliases, Brightness, canonical, envelope, recognise, Rhythm,
)
import numpy as np
import pytest

EXPOSURE = 0.5  # frame intervals
STEPS = 4096  # of a period


def brightness(
    pattern: Pattern, count: int, *, phase: float = 0.3, full: float = 1000.0, drift: float = 0.0,
    exposure: float = EXPOSURE, seed: int = 1,
) -> Brightness:
    """Return what so many frames show of a pattern whose times are frame intervals."""
    random = np.random.default_rng(seed)
    clock = np.arange(float(count))
    table, _ = look(pattern, STEPS, exposure)
    part = (clock / pattern.period + phase) % 1.0
    shares = table[(part * STEPS).astype(int) % STEPS]
    shine = full * (1.0 + drift * clock / count)
    flux = shares * shine * (1.0 + 0.02 * random.standard_normal(count))
    flux = np.where(shares > 0.05, flux + 10.0 * random.standard_normal(count), 0.0)
    return Brightness(clock, flux, np.full(count, 10.0), 0.05 * full)


def free(bits: str, bit: float) -> Pattern:
    """Return a code of bits of this many frames."""
    return code('it', bits, 1.0 / bit)


@pytest.mark.parametrize('frequency, duty, known', [
    (6.0, 0.5, True), (10.0, 0.5, False), (13.7, 0.5, True), (1.5, 0.2, True), (25.3, 0.4, False),
])
def test_a_wave(frequency: float, duty: float, known: bool) -> None:
    """At 60 frames/s: within 3 sigma, sigma below 1 part in 200, with and without the exposure."""
    light = brightness(wave('it', frequency / 60.0, duty), 180)
    found = recognise(light, EXPOSURE if known else 0.0)
    assert found.kind == 'wave'
    period = 60.0 / frequency
    assert abs(found.period - period) < 3.0 * found.period_sigma < 0.015 * period
    assert abs(found.duty - duty) < 3.0 * found.duty_sigma + 0.01
    assert found.misfit < 1.0


@pytest.mark.parametrize('bits, bit, frames', [
    ('1101000', 1.0, 1), ('1101000', 2.0, 2), ('1110100110', 60.0 / 59.7, 0),
    ('110101001001000', 1.0, 1), ('110101001001000', 60.0 / 60.3, 0),
])
def test_a_code(bits: str, bit: float, frames: int) -> None:
    """Bits right up to rotation, and in step or not."""
    # In step, bits change in the middle between two exposures.
    light = brightness(free(bits, bit), 180, phase=0.5 / len(bits) / bit if frames else 0.3)
    found = recognise(light, EXPOSURE)
    assert found.kind == 'code' and len(found.bits) == len(bits)
    assert found.bits in 2 * bits
    assert found.frames_per_bit == frames
    assert abs(found.bit - bit) < 3.0 * found.bit_sigma


def test_bits_of_two_frames_are_not_two_bits() -> None:
    """Free-running: 11001111000000 in single frames is 1011000 in pairs of them."""
    found = recognise(brightness(free('1011000', 60.0 / 29.6), 300), 0.0, sigmas=False)
    assert found.bits == '1100010' and found.bit == pytest.approx(60.0 / 29.6, rel=1e-3)


def test_brightness_may_drift() -> None:
    """By 40 % in the recording; the full flux follows."""
    light = brightness(free('1101000', 1.005), 240, drift=-0.4)
    found = recognise(light, EXPOSURE)
    assert found.bits == '1101000'
    full = envelope(light, found.share(light.clock))
    np.testing.assert_allclose(full[[60, 180]], [900.0, 700.0], rtol=0.03)


@pytest.mark.parametrize('bits, count', [('110101001001000', 24), ('1101000', 12)])
def test_too_few_frames_are_said_to_be(bits: str, count: int) -> None:
    """Less than two periods could be anything."""
    assert recognise(brightness(free(bits, 1.005), count), EXPOSURE).kind == 'short'


def test_blinking_at_random_is_no_pattern() -> None:
    """Two lights of chance, 200 frames each."""
    for seed in range(2):
        random = np.random.default_rng(seed)
        runs = random.integers(1, 6, 200)
        on = 1000.0 * np.repeat(np.arange(200.0) % 2.0, runs)[:200]
        light = Brightness(np.arange(200.0), on, np.full(200, 10.0), 50.0)
        assert recognise(light, EXPOSURE, sigmas=False).kind == 'irregular'


def test_what_is_always_on_is_steady_or_modulated() -> None:
    """A lamp, and one whose brightness goes up and down by a third with the alias of the mains."""
    clock = np.arange(120.0)
    noise = 20.0 * np.random.default_rng(1).standard_normal(120)
    for depth, kind in ((0.0, 'steady'), (0.3, 'modulated')):
        flux = 1000.0 + 1000.0 * depth * np.sin(2.0 * np.pi * clock / 3.01) + noise
        found = recognise(Brightness(clock, flux, np.full(120, 20.0), 50.0), 0.0)
        assert found.kind == kind
        if depth:
            assert found.period == pytest.approx(3.01, abs=5.0 * found.period_sigma)


def test_aliases_are_told_by_the_exposure_alone() -> None:
    """With it the edges tell 10 Hz from 50, 70 and 110 Hz; without it nothing does."""
    light = brightness(wave('it', 10.3 / 60.0, 0.5), 180)
    found = recognise(light, EXPOSURE)
    assert aliases(light, found, EXPOSURE, 2.0) == []
    others = aliases(light, recognise(light, 0.0), 0.0, 2.0)
    assert [60.0 * each for each in others] == pytest.approx([49.7, 70.3, 109.7], abs=0.05)


def test_rotations_are_one_code() -> None:
    """It begins where it is the greatest number; the time of its first bit goes with it."""
    for shift in range(7):
        bits = '1101000'[shift:] + '1101000'[:shift]
        found = canonical(Rhythm('code', 7.0, bits=bits, rise=float(shift)))
        assert found.bits == '1101000' and found.rise % 7.0 == 0.0

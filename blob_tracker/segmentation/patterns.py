"""Which codes and frequencies can be told apart, and what to set for lights that were seen."""

from __future__ import annotations

from collections.abc import Mapping
import math

from blob_tracker.blinking.patterns import LONGEST_BITS, MAINS_HZ
from blob_tracker.blinking.survey import Light
from blob_tracker.flash_text import DUTIES
import numpy as np
from numpy.typing import NDArray

SAME_DUTY = 0.1  # of a period, by which the times differ for which two waves are on
MOST_LIGHTS = 32  # patterns, all of which each new point is compared with
HIGHEST_PART = 0.45  # of the frame rate; beyond 0.5 a frequency is aliased
LOWEST_PART = 0.02  # of the frame rate: a period of 50 frames
APART = 0.02  # of a frequency by which another one differs: clocks are off by 1 %


def check_patterns(
    codes: Mapping[str, str], frequencies: Mapping[str, float], duty: float
) -> None:
    """
    Raise ValueError if a code or frequency is none, or two of them are one.

    Parameters
    ----------
    codes : mapping of str to str
        Bits by name.
    frequencies : mapping of str to float
        Hz by name.
    duty : float
        Of those with a frequency.

    """
    if not codes and not frequencies:
        raise ValueError(
            "there is no light; write flash.codes as 'port:1101000,starboard:1110100' or "
            "flash.frequencies as 'port:6.0,starboard:10.0'"
        )
    if len(codes) + len(frequencies) > MOST_LIGHTS:
        raise ValueError(f'{len(codes) + len(frequencies)} lights; {MOST_LIGHTS} can be followed')
    for name in [*codes, *frequencies]:
        if name and not (name.isidentifier() and name.isascii()):
            raise ValueError(f"a light is called '{name}'; it must be a word fit for a topic")
        if name in codes and name in frequencies:
            raise ValueError(f"'{name}' has a code and a frequency; a light has one of them")
    for name, bits in codes.items():
        if set(bits) != {'0', '1'}:
            raise ValueError(
                f"the code of '{name}' is '{bits}'; it must have zeros and ones (in YAML in "
                'quotes: without them 00010111 is the number 4169)'
            )
        if len(bits) > LONGEST_BITS:
            raise ValueError(f"the code of '{name}' has {len(bits)} bits; {LONGEST_BITS} at most")
    names = list(codes)
    for index, first in enumerate(names):
        for second in names[index + 1:]:
            _check_apart(first, codes[first], second, codes[second])
    if not 0.0 < duty < 1.0:
        raise ValueError(f'a duty of {duty}; it must be above 0 and below 1')
    rates = sorted((rate, name) for name, rate in frequencies.items())
    for rate, name in rates:
        if not 0.0 < rate < math.inf:
            raise ValueError(f'the frequency of {_called(name)} is {rate} Hz; it must be above 0')
    for (low, one), (high, other) in zip(rates, rates[1:]):
        if high < (1.0 + APART) * low:
            raise ValueError(
                f"'{one}' and '{other}' flash at {low:g} and {high:g} Hz; clocks are off by 1 %: "
                f'take {(1.0 + 2.0 * APART) * low:.3g} Hz or more for one of them'
            )


def _called(name: str) -> str:
    """Return what to call a light in a sentence; the only one has no name."""
    return f"'{name}'" if name else 'the light'


def rate_fault(frequencies: Mapping[str, float], rate: float) -> str:
    """
    Say which frequency a camera of this frame rate, Hz, cannot tell; empty if there is none.

    A frequency f is seen as |f - k rate|: above half the frame rate it looks like another one,
    and lamps on the mains look like slow lights.
    """
    for name, frequency in frequencies.items():
        if not LOWEST_PART * rate <= frequency <= HIGHEST_PART * rate:
            fault = (
                f'{_called(name)} flashes at {frequency:g} Hz; {rate:.1f} frames a second show '
                f'{LOWEST_PART * rate:.1f} to {HIGHEST_PART * rate:.1f} Hz'
            )
            seen = abs(frequency - rate * round(frequency / rate))
            if frequency > 0.5 * rate:
                fault += f': it looks like {seen:.1f} Hz'
                twins = [
                    other for other, its in frequencies.items()
                    if other != name and abs(its - seen) < APART * its
                ]
                fault += f", and so does '{twins[0]}'" if twins else ''
            return fault
        for mains in MAINS_HZ:
            seen = abs(mains - rate * round(mains / rate))
            if abs(seen - frequency) < APART * frequency:
                return (
                    f'{_called(name)} flashes at {frequency:g} Hz, and so does a lamp of '
                    f'{mains:g} Hz as {rate:.1f} frames a second show it ({seen:.1f} Hz): take '
                    'another frequency'
                )
    return ''


def twin_fault(
    codes: Mapping[str, str], bits_per_second: float, frequencies: Mapping[str, float], duty: float
) -> str:
    """
    Say which code and frequency are one pattern; empty if there are none.

    A code that is on once in its length is a wave: 1100 at 60 bits/s is one of 15 Hz.
    """
    for name, bits in codes.items():
        if (bits + bits[0]).count('01') != 1:
            continue
        rate, on = bits_per_second / len(bits), bits.count('1') / len(bits)
        for other, frequency in frequencies.items():
            if abs(frequency - rate) < APART * rate and abs(on - duty) < SAME_DUTY:
                return (
                    f"the code {bits} of '{name}' is a wave of {rate:.4g} Hz, and '{other}' "
                    f'flashes at {frequency:g} Hz: they cannot be distinguished; take a code that '
                    'is on more than once'
                )
    return ''


def flash_values(lights: Mapping[str, Light]) -> dict[str, str | float | int]:
    """
    Return the parameters of the flash mode that follows these lights.

    Parameters
    ----------
    lights : mapping of str to Light
        Waves and codes by name; a wave that is alone needs none.

    Returns
    -------
    dict
        Parameter to value.

    """
    if all(light.alternates for light in lights.values()):
        return {'flash.mode': 'alternate'}
    codes = {name: light for name, light in lights.items() if light.rhythm.bits}
    waves = {name: _known_frequency(light) for name, light in lights.items() if name not in codes}
    values: dict[str, str | float | int] = {'flash.mode': 'coded' if codes else 'periodic'}
    if codes:
        values['flash.codes'] = ','.join(
            f'{name}:{light.rhythm.bits}' for name, light in codes.items()
        )
        frames = {light.frames_per_bit for light in codes.values()}
        if len(frames) == 1 and 0 not in frames:
            values['flash.frames_per_bit'] = frames.pop()
        else:
            rates = [light.bits_per_second for light in codes.values()]
            values['flash.bits_per_second'] = round(sum(rates) / len(rates), 2)
    if waves:
        if '' in waves:
            values['flash.frequency'] = waves['']
        else:
            values['flash.frequencies'] = ','.join(f'{k}:{v:g}' for k, v in waves.items())
        duties = [lights[name].rhythm.duty for name in waves]
        values['flash.duty'] = round(float(np.clip(sum(duties) / len(duties), *DUTIES)), 2)
    return values


def _known_frequency(light: Light) -> float:
    """Return the frequency of a light in the digits that are known, Hz."""
    if not light.frequency_sigma:
        return float(f'{light.frequency:.4g}')
    digits = math.floor(-math.log10(max(light.frequency_sigma, 1e-4)))
    return round(light.frequency, max(digits, 0))


def _check_apart(first: str, one: str, second: str, other: str) -> None:
    """Raise ValueError if one code is the other one begun elsewhere."""
    length = math.lcm(len(one), len(other))
    a = _bits(one * (length // len(one)))
    b = _bits(other * (length // len(other)))
    for shift in range(len(other)):
        if (np.roll(b, shift) == a).all():
            raise ValueError(
                f"the codes of '{first}' and '{second}' are one code begun at another bit ({one} "
                f'and {other}): they cannot be distinguished; take one that differs in every '
                'rotation'
            )


def _bits(text: str) -> NDArray[np.bool_]:
    return np.array([bit == '1' for bit in text])

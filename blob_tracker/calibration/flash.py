"""What to set so that the lights which were seen to blink are tracked, and what speaks against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
import math

from blob_tracker.blinking.patterns import LONGEST_BITS
from blob_tracker.blinking.survey import Light, shortest_look
from blob_tracker.segmentation.patterns import check_patterns, rate_fault

TRACKED_CLOCK = 0.01  # of a bit rate, by which a light's clock may be off
SURE_CLOCK = 1e-3  # of the bit rate: clocks that run free are off by as much, or drift
SAME_DUTY = 0.1  # by which the duties of waves may differ from the one that is set
NOMINAL_HZ = 0.1  # of whose multiples the nearest is taken for what a wave was meant to be
SHOWN_ALIASES = 3
NOISY_HZ = 0.5 * NOMINAL_HZ  # of a frequency: then nobody knows which it was


@dataclass(frozen=True)
class FlashSettings:
    """
    Parameters of the segmenter for some lights.

    Parameters
    ----------
    values : dict
        Parameter to value; empty where there is nothing to set.
    named : tuple of str
        What each light is called there, '' where it is not among them.
    notes : tuple of str
        What speaks against it, and what is left out.

    """

    values: dict[str, str | float | int] = field(default_factory=dict)
    named: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def flash_settings(lights: Sequence[Light], exposure: float) -> FlashSettings:
    """
    Return the parameters of the segmenter that track the lights.

    Parameters
    ----------
    lights : sequence of Light
        Of one recording.
    exposure : float
        Of a frame, s; 0 where it is not known.

    """
    usable = [
        light.rhythm.kind in ('wave', 'code') and not light.mains for light in lights
    ]
    if not any(usable):
        return FlashSettings(named=('',) * len(lights))
    chosen = [light for light, good in zip(lights, usable) if good]
    if all(light.alternates for light in chosen):
        many = (
            f'{len(chosen)} lights are on in every other frame: one is followed, and nothing '
            'tells which; give them codes'
        )
        return FlashSettings(
            {'flash.mode': 'alternate'}, ('',) * len(lights), (many,) if len(chosen) > 1 else ()
        )
    names = tuple(
        f'light_{index}' if good and not light.alternates else ''
        for index, (light, good) in enumerate(zip(lights, usable), start=1)
    )
    codes = {name: light for name, light in zip(names, lights) if name and light.rhythm.bits}
    waves = {name: light for name, light in zip(names, lights) if name and not light.rhythm.bits}
    values: dict[str, str | float | int] = {'flash.mode': 'coded' if codes else 'periodic'}
    said = [
        f'light {index} is on in every other frame: that is flash.mode alternate, beside which no '
        'other light is tracked' for index, light in enumerate(lights, start=1) if light.alternates
    ]
    if codes:
        values['flash.codes'] = ','.join(
            f'{name}:{light.rhythm.bits}' for name, light in codes.items()
        )
        said += _set_bit_rate(values, list(codes.values()))
    frequencies = {name: _rounded(light) for name, light in waves.items()}
    if waves:
        values['flash.frequencies'] = ','.join(f'{k}:{v:g}' for k, v in frequencies.items())
        duties = [light.rhythm.duty for light in waves.values()]
        values['flash.duty'] = round(sum(duties) / len(duties), 2)
        if max(duties) - min(duties) > SAME_DUTY:
            said.append(
                f'the lights are on for {min(duties):.2f} to {max(duties):.2f} of their periods; '
                'there is one flash.duty for all of them'
            )
    if exposure:
        values['flash.exposure'] = exposure
    fault = _fault({name: light.rhythm.bits for name, light in codes.items()}, frequencies,
                   lights[0].rate)
    return FlashSettings(values, names, (*said, *([fault] if fault else [])))


def _set_bit_rate(values: dict[str, str | float | int], lights: Sequence[Light]) -> list[str]:
    """Set how fast codes are sent; return what speaks against it."""
    frames = {light.rhythm.frames_per_bit * surely_in_step(light) for light in lights}
    if len(frames) == 1 and 0 not in frames:
        values['flash.frames_per_bit'] = frames.pop()
        return []
    rates = [light.bits_per_second for light in lights]
    mean = sum(rates) / len(rates)
    values['flash.bits_per_second'] = round(mean, 2)
    if max(rates) - min(rates) > 2.0 * TRACKED_CLOCK * mean:
        return [
            f'the codes have {min(rates):.2f} to {max(rates):.2f} bits a second; there is one '
            'flash.bits_per_second, by which clocks may be off by 1 %'
        ]
    return []


def _fault(codes: dict[str, str], frequencies: dict[str, float], rate: float) -> str:
    """Return why these cannot be tracked together; empty where they can."""
    try:
        check_patterns(codes, frequencies, 0.5)
    except ValueError as error:
        return str(error)
    return rate_fault(frequencies, rate)


def _rounded(light: Light) -> float:
    """Return the frequency of a light in the digits that are known, Hz."""
    digits = math.floor(-math.log10(max(light.frequency_sigma, 1e-4)))
    return round(light.frequency, max(digits, 0))


def surely_in_step(light: Light) -> bool:
    """Tell whether a code is in step with the frames so nearly that no free clock would be."""
    rhythm = light.rhythm
    return rhythm.frames_per_bit > 0 and rhythm.bit_sigma < SURE_CLOCK * rhythm.bit


def clock_error(light: Light) -> tuple[str, float, float] | None:
    """
    Return against what the clock of a light is held, how far it is off, and the sigma of that.

    A code against the frames: bits of a whole number of them; a wave against the nearest multiple
    of 0.1 Hz, where it is known so well. In parts per million.
    """
    rhythm = light.rhythm
    if rhythm.kind == 'code':
        frames = max(round(rhythm.bit), 1)
        if abs(rhythm.bit / frames - 1.0) > TRACKED_CLOCK:
            return None
        words = f'{frames} frame{"s" if frames > 1 else ""} a bit'
        return words, 1e6 * (frames / rhythm.bit - 1.0), 1e6 * rhythm.bit_sigma / rhythm.bit
    if rhythm.kind != 'wave' or 3.0 * light.frequency_sigma > NOISY_HZ:
        return None
    nominal = NOMINAL_HZ * max(round(light.frequency / NOMINAL_HZ), 1)
    if light.alternates:
        nominal = 0.5 * light.rate
    relative = light.frequency_sigma / light.frequency
    return f'{nominal:.4g} Hz', 1e6 * (light.frequency / nominal - 1.0), 1e6 * relative


def notes(light: Light) -> list[str]:
    """Return what is to be said of a light beside its numbers."""
    rhythm, said = light.rhythm, []
    clock = clock_error(light)
    if clock is not None and not light.mains:
        against, error, sigma = clock
        said.append(f'its clock is off {against} by {error:+.0f} ± {sigma:.0f} ppm')
    if rhythm.kind == 'short':
        said.append(
            'its pattern did not come twice: record '
            f'{shortest_look(light, LONGEST_BITS):.0f} s, which shows any code of {LONGEST_BITS} '
            'bits twice'
        )
    if rhythm.kind == 'irregular':
        said.append(
            'it does not keep a rate, or flashes quicker than the frames, or two lights cross: '
            'what blinks at random cannot be tracked'
        )
    if light.mains:
        said.append(
            f'a lamp on the mains looks so, and so does a light of {light.frequency:.2f} Hz: '
            'switch the lamps off, or take another frequency'
        )
    elif light.aliases:
        others = ', '.join(f'{each:.1f}' for each in light.aliases[:SHOWN_ALIASES])
        said.append(
            f'{light.rate:.2f} evenly spaced frames a second do not tell {light.frequency:.2f} Hz '
            f'from {others} Hz ...: record once more at another frame rate if it may be one of '
            'these (--exposure may rule them out)'
        )
    if rhythm.frames_per_bit and not surely_in_step(light):
        said.append(
            'whether it is in step or runs free is known no better than that: '
            'flash.bits_per_second tracks it either way; record longer for flash.frames_per_bit'
        )
    if rhythm.kind == 'wave' and not light.mains and not light.alternates:
        fault = rate_fault({'it': light.frequency}, light.rate)
        said += [fault] if fault else []
    return said


def enough(seconds: float, rate: float) -> float:
    """Return for how long one must look so that the slowest wave is seen three times, s."""
    slowest = 50.0 / rate  # as flash.frequency may be
    return max(0.0, math.ceil(3.0 * slowest) - seconds)

"""What to set so that the lights which were seen to blink are tracked, and what speaks against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
import math

from blob_tracker.blinking.patterns import LONGEST_BITS
from blob_tracker.blinking.survey import Light
from blob_tracker.flash_text import DUTIES
from blob_tracker.segmentation.patterns import (
    check_patterns, flash_values, rate_fault, twin_fault,
)
import numpy as np

TRACKED_CLOCK = 0.01  # of a bit rate, by which a light's clock may be off
SAME_DUTY = 0.1  # by which the duties of waves may differ from the one that is set
NOMINAL_HZ = 0.1  # of whose multiples the nearest is taken for what a wave was meant to be
SHOWN_ALIASES = 3
DRIFTS_PPM = 100.0  # by which stamps are off
NOISY_HZ = 0.5 * NOMINAL_HZ  # of a frequency: then nobody knows which it was


@dataclass(frozen=True)
class FlashSettings:
    """
    Parameters of the segmenter for some lights.

    Parameters
    ----------
    values : dict
        Parameter to value; empty if there is nothing to set.
    named : tuple of str
        What each light is called there, '' where it is alone or not among them.
    notes : tuple of str
        What speaks against it, and what is left out.

    Examples
    --------
    The second of three lights is a lamp on the mains:

    >>> settings = FlashSettings(
    ...     {'flash.mode': 'periodic', 'flash.frequencies': 'light_1:6,light_3:13.7'},
    ...     ('light_1', '', 'light_3'),
    ... )
    >>> settings.lights
    'light_1,light_3'

    """

    values: dict[str, str | float | int] = field(default_factory=dict)
    named: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def lights(self) -> str:
        """Return `lights` of locator and tracker: the names that are set; empty without any."""
        return ','.join(filter(None, self.named))


def flash_settings(lights: Sequence[Light], exposure: float) -> FlashSettings:
    """
    Return the parameters of the segmenter that track the lights.

    Parameters
    ----------
    lights : sequence of Light
        Of one recording.
    exposure : float
        Of a frame, s; 0 where it is not known.

    Examples
    --------
    A wave of 13.7 Hz, as the survey of a recording of 60 frames a second finds it; where it was
    and how bright does not matter:

    >>> from blob_tracker.blinking.paths import Path
    >>> from blob_tracker.blinking.recognition import Brightness, Rhythm
    >>> path, brightness = Path(*np.ones((6, 2))), Brightness(*np.ones((3, 6)), least=0.1)
    >>> wave = Rhythm('wave', period=60.0 / 13.7, period_sigma=4e-4, duty=0.5)
    >>> flash_settings([Light(path, brightness, wave, rate=60.0)], exposure=0.0).values
    {'flash.mode': 'periodic', 'flash.frequency': 13.7, 'flash.duty': 0.5}

    """
    chosen: dict[str, Light] = {}
    said: list[str] = []
    for index, light in enumerate(lights, start=1):
        if not light.repeats or light.alternates:
            continue
        fault = _fault({**chosen, f'light_{index}': light})
        if fault:
            said.append(f'light {index} is left out: {fault}')
        else:
            chosen[f'light_{index}'] = light
    in_step = {
        index: light for index, light in enumerate(lights, start=1)
        if light.repeats and light.alternates
    }
    if in_step and not chosen:
        if len(in_step) > 1:
            said.append(
                f'{len(in_step)} lights are on in every other frame: one is followed, but which '
                'one is chance; give them codes'
            )
        values = flash_values({'': light for light in in_step.values()})
        return FlashSettings(values, ('',) * len(lights), tuple(said))
    said += [
        f'light {index} is on in every other frame: that is flash.mode alternate, beside which no '
        'other light is tracked' for index in in_step
    ]
    said += _duty_notes(chosen)
    names = tuple(
        f'light_{index}' if f'light_{index}' in chosen else ''
        for index in range(1, len(lights) + 1)
    )
    if len(chosen) == 1 and not next(iter(chosen.values())).rhythm.bits:
        names, chosen = ('',) * len(lights), {'': light for light in chosen.values()}
    values = flash_values(chosen) if chosen else {}
    if values and exposure:
        values['flash.exposure'] = exposure
    return FlashSettings(values, names, tuple(said))


def _fault(lights: dict[str, Light]) -> str:
    """Say why a mode would refuse these lights, or lose one of them; empty if none does."""
    codes = {name: light.rhythm.bits for name, light in lights.items() if light.rhythm.bits}
    waves = {name: light.frequency for name, light in lights.items() if name not in codes}
    rates = [lights[name].bits_per_second for name in codes]
    if rates and max(rates) - min(rates) > 2.0 * TRACKED_CLOCK * min(rates):
        return (
            f'the codes have {min(rates):.2f} to {max(rates):.2f} bits a second; there is one '
            'flash.bits_per_second, by which clocks may be off by 1 %'
        )
    duty = float(flash_values(lights).get('flash.duty', 0.5))
    try:
        check_patterns(codes, waves, duty)
    except ValueError as error:
        return str(error)
    frame_rate = next(iter(lights.values())).rate
    rate = sum(rates) / max(len(rates), 1)
    return rate_fault(waves, frame_rate) or twin_fault(codes, rate, waves, duty)


def _duty_notes(lights: dict[str, Light]) -> list[str]:
    """Return what speaks against the one duty of all waves."""
    duties = {
        name: light.rhythm.duty for name, light in lights.items() if not light.rhythm.bits
    }
    low, high = DUTIES
    said = [
        f'{name} is on for {duty:.3f} of its period: flash.duty may be {low:g} to {high:g}'
        for name, duty in duties.items() if not low <= duty <= high
    ]
    if duties and max(duties.values()) - min(duties.values()) > SAME_DUTY:
        said.append(
            f'the lights are on for {min(duties.values()):.2f} to {max(duties.values()):.2f} of '
            'their periods; there is one flash.duty for all of them'
        )
    return said


def clock_error(light: Light) -> tuple[str, float, float] | None:
    """
    Return against what the clock of a light is held, how far it is off, and the sigma of that.

    A code against the frames: bits of a whole number of them; a wave against the nearest multiple
    of 0.1 Hz, where it is known so well. In parts per million.

    Examples
    --------
    A wave that was to have 13.7 Hz, and has 13.705 Hz by a camera of 60 frames a second:

    >>> from blob_tracker.blinking.paths import Path
    >>> from blob_tracker.blinking.recognition import Brightness, Rhythm
    >>> path, brightness = Path(*np.ones((6, 2))), Brightness(*np.ones((3, 6)), least=0.1)
    >>> wave = Rhythm('wave', period=60.0 / 13.705, period_sigma=4e-4, duty=0.5)
    >>> against, error, sigma = clock_error(Light(path, brightness, wave, rate=60.0))
    >>> against, round(error), round(sigma)  # Hz, ppm, ppm
    ('13.7 Hz', 365, 91)

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
    """
    Return what is to be said of a light beside its numbers.

    Examples
    --------
    A wave that was to have 13.7 Hz, and has 13.705 Hz by a camera of 60 frames a second:

    >>> from blob_tracker.blinking.paths import Path
    >>> from blob_tracker.blinking.recognition import Brightness, Rhythm
    >>> path, brightness = Path(*np.ones((6, 2))), Brightness(*np.ones((3, 6)), least=0.1)
    >>> wave = Rhythm('wave', period=60.0 / 13.705, period_sigma=4e-4, duty=0.5)
    >>> notes(Light(path, brightness, wave, rate=60.0))
    ['its clock is off 13.7 Hz by +365 ± 91 ppm']

    """
    rhythm, said = light.rhythm, []
    clock = clock_error(light)
    if clock is not None and not light.mains:
        against, error, sigma = clock
        if not light.alternates:
            said.append(f'its clock is off {against} by {error:+.0f} ± {sigma:.0f} ppm')
        elif abs(error) > DRIFTS_PPM + 3.0 * sigma:
            # Whether it is faster or slower no frame tells, and in less than a beat the light may
            # as well grow darker: no sign, no sigma.
            said.append(
                f'it is off half the frame rate by about {round(abs(error), -2):.0f} ppm, and '
                'drifts through the frames: flash.mode alternate follows it'
            )
    if rhythm.kind == 'short':
        said.append(
            'its pattern did not come twice: record '
            f'{_shortest_look(light):.0f} s, which shows any code of {LONGEST_BITS} '
            'bits twice'
        )
    if rhythm.kind == 'irregular':
        said.append(
            'it does not keep a rate, or flashes quicker than the frames, or two lights cross: a '
            'light that blinks at random cannot be tracked'
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
    if rhythm.frames_per_bit and not light.frames_per_bit:
        said.append(
            'whether it is in step or runs free is known no better than that: '
            'flash.bits_per_second tracks it either way; record longer for flash.frames_per_bit'
        )
    return said


def _shortest_look(light: Light) -> float:
    """Return for how long a light must be watched so that two periods of any code are seen, s."""
    shown = light.brightness.flux > 0.0
    runs = np.diff(np.flatnonzero(np.diff(shown)))
    shortest = float(runs.min()) if len(runs) else 1.0
    return math.ceil(2.5 * LONGEST_BITS * shortest / light.rate)


def enough(seconds: float, rate: float) -> float:
    """
    Return for how long one must look so that the slowest wave is seen three times, s.

    Examples
    --------
    Of 60 frames a second, after a look of 2 s:

    >>> enough(2.0, 60.0)  # s
    1.0

    """
    slowest = 50.0 / rate  # as flash.frequency may be
    return max(0.0, math.ceil(3.0 * slowest) - seconds)

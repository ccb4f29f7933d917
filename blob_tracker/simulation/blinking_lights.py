"""Lights that blink, each in its own way, and leave streaks where they move."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from blob_tracker.simulation.point_light import Light
from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.scene import Scene
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.simulation.waveforms import always, coded, in_step, periodic, Waveform

BEHIND = 0.13  # of the path, from light to light: three of them never come within 49 px at VGA
FIRST_PHASE = 0.13  # of the first period: no light rises in the middle of an exposure


def blinking_lights(
    waveforms: Mapping[str, Waveform],
    *,
    width: int = 640,
    height: int = 480,
    rate: float = 60.0,
    exposure: float = 0.5,
    sigma: float = 2.0,
    amplitude: float = 150.0,
    profile: Profile = Gaussian(),
    background: float = 40.0,
    texture: float = 8.0,
    reach: float = 0.7,
    period: float = 9.0,
    sensor: Sensor = Sensor(),
    seed: int = 1,
) -> tuple[Scene, dict[str, Light]]:
    """
    Return a scene with lights that go all over the picture, one behind the other.

    Parameters
    ----------
    waveforms : mapping of str to callable
        How each light blinks, see `waveforms`.
    width, height, rate, exposure, background, texture, sensor, seed
        See `Scene`.
    sigma, amplitude, profile, period
        See `Light`.
    reach : float
        Greatest distance of the path from the middle of the frame, as a part of its half-size.

    Returns
    -------
    Scene
        The lights are its elements; `spot.truth_of` tells the truth of each.
    dict of str to Light
        The lights by name.

    Examples
    --------
    A wave and a code:

    >>> waveforms = {'port': periodic(6.0, 0.5), 'mast': coded('1101000', 1.0 / 30.0)}
    >>> scene, lights = blinking_lights(waveforms, width=160, height=120)
    >>> scene.frame(0).shape, sorted(lights)
    ((120, 160), ['mast', 'port'])
    >>> place = lights['mast'].spot(0.5)
    >>> round(place.x), round(place.y)  # px
    (120, 28)

    """
    lights = {
        name: Light(
            0.5 * (width - 1),
            0.5 * (height - 1),
            sigma,
            amplitude,
            waveform,
            reach_x=reach * 0.5 * width,
            reach_y=reach * 0.5 * height,
            period=period,
            start=BEHIND * index,
            profile=profile,
        )
        for index, (name, waveform) in enumerate(waveforms.items())
    }
    scene = Scene(
        elements=tuple(lights.values()),
        width=width,
        height=height,
        rate=rate,
        exposure=exposure,
        background=background,
        texture=texture,
        sensor=sensor,
        streaks=True,
        seed=seed,
    )
    return scene, lights


def waveforms_of(
    mode: str,
    *,
    rate: float = 60.0,
    frequency: float = 15.0,
    duty: float = 0.5,
    frequencies: Mapping[str, float] | None = None,
    codes: Mapping[str, str] | None = None,
    frames_per_bit: int = 1,
    bits_per_second: float = 0.0,
    clock_error: float = 0.0,
    lights: Iterable[str] = ('',),
) -> dict[str, Waveform]:
    """
    Return how the lights blink for which a flash mode is made, by name.

    Parameters
    ----------
    mode : str
        A key of `segmentation.FLASH_MODES`.
    rate : float
        Frames a second.
    frequency, duty, frequencies, codes, frames_per_bit, bits_per_second
        See `segmentation.flash_by_name`.
    clock_error : float
        Of the lights' own clocks, as a part of their rate.
    lights : iterable of str
        Names of the lights in the modes steady and alternate, which blink as one.

    Examples
    --------
    A code with two frames for a bit, at six of 30 times a second:

    >>> import numpy as np
    >>> waveforms = waveforms_of('coded', codes={'port': '1101000'}, frames_per_bit=2)
    >>> waveforms['port'](np.arange(0.01, 0.2, 1.0 / 30.0)).tolist()
    [1.0, 1.0, 0.0, 1.0, 0.0, 0.0]

    """
    if mode in ('steady', 'alternate'):
        return dict.fromkeys(lights, always if mode == 'steady' else in_step(rate))
    pace = 1.0 + clock_error
    named = dict(frequencies or {}) if mode in ('periodic', 'coded') else {}
    if not named and mode != 'coded':
        named = {'': frequency}
    found = {
        name: periodic(pace * each, duty, FIRST_PHASE * (index + 1))
        for index, (name, each) in enumerate(named.items())
    }
    if mode == 'coded':
        for index, (name, bits) in enumerate((codes or {}).items()):
            # In step, bits change in the middle between two exposures.
            bit_time, start = frames_per_bit / rate, -0.5 / rate
            if bits_per_second:
                bit_time = 1.0 / (pace * bits_per_second)
                start = -FIRST_PHASE * (index + 1) * bit_time
            found[name] = coded(bits, bit_time, start)
    return found

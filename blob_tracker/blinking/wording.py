"""How a light blinks, in words."""

from __future__ import annotations

import math

from blob_tracker.blinking.survey import Light


def describe(light: Light) -> str:
    """Return in words how a light blinks."""
    rhythm = light.rhythm
    frequency = with_sigma(light.frequency, light.frequency_sigma)
    if rhythm.kind == 'short':
        return f'blinks ({rhythm.changes} changes), but not for long enough to say how'
    if rhythm.kind == 'irregular':
        return f'blinks ({rhythm.changes} changes) without a period'
    if light.mains:
        return f'lamp of {light.mains:g} Hz, seen at {frequency} Hz'
    if rhythm.kind == 'modulated':
        return f'never dark, brighter and darker at {frequency} Hz'
    duty = with_sigma(rhythm.duty, rhythm.duty_sigma)
    if light.alternates:
        return f'on in every other frame, {frequency} Hz'
    if rhythm.kind == 'wave':
        return f'wave of {frequency} Hz, on for {duty} of it'
    rate = with_sigma(light.bits_per_second, light.bits_per_second * rhythm.bit_sigma / rhythm.bit)
    frames = rhythm.frames_per_bit
    timing = f'in step, {frames} frame{"s" if frames > 1 else ""} a bit' if frames else (
        'free-running'
    )
    return f'code {rhythm.bits}, {timing}, {rate} bits/s, on for {duty} of it'


def with_sigma(value: float, sigma: float) -> str:
    """Return a value with its standard deviation, of which two digits are given."""
    if not sigma > 0.0:
        return f'{value:.4g}'
    digits = max(0, 1 - math.floor(math.log10(sigma)))
    return f'{value:.{digits}f} ± {sigma:.{digits}f}'

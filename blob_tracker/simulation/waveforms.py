"""How bright a light is at a time: from times, s, to parts of its amplitude."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Times = TypeVar('Times', float, NDArray[np.float64])
Waveform = Callable[[NDArray[np.float64]], NDArray[np.float64]]

SLICES = 64  # of an exposure; the part of it in which a light is on is known to one of them


def always(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Return the waveform of a light that is never off.

    Examples
    --------
    At two times:

    >>> always(np.array([0.0, 0.5])).tolist()
    [1.0, 1.0]

    """
    return np.ones_like(times)


def in_step(rate: float) -> Waveform:
    """
    Return a light that is on in the even ones of `rate` frames a second.

    Examples
    --------
    Frames 0 to 3 of 60 a second:

    >>> in_step(60.0)(np.arange(4) / 60.0).tolist()
    [1.0, 0.0, 1.0, 0.0]

    """
    return lambda times: (np.rint(times * rate) % 2 == 0).astype(float)


def periodic(frequency: float, duty: float, phase: float = 0.0) -> Waveform:
    """
    Return a light that is on for the part `duty` of each period; frequency in Hz.

    Examples
    --------
    On for a quarter of each second:

    >>> periodic(1.0, 0.25)(np.array([0.1, 0.3, 0.9, 1.1])).tolist()
    [1.0, 0.0, 0.0, 1.0]

    """
    return lambda times: ((times * frequency + phase) % 1.0 < duty).astype(float)


def coded(bits: str, bit_time: float, start: float = 0.0) -> Waveform:
    """
    Return a light that repeats its bits, each for `bit_time` s.

    Examples
    --------
    Bits of 0.1 s each:

    >>> light = coded('1101', 0.1)
    >>> light(np.array([0.05, 0.15, 0.25, 0.35, 0.45])).tolist()
    [1.0, 1.0, 0.0, 1.0, 1.0]

    """
    values = np.array([float(bit == '1') for bit in bits])
    return lambda times: values[((times - start) // bit_time).astype(int) % len(values)]


def sinusoid(frequency: float, modulation: float, phase: float = 0.0) -> Waveform:
    """
    Return a light of the mean brightness 1 that goes up and down.

    A lamp on the mains flickers at twice their frequency, 100 or 120 Hz; its modulation is
    (max - min) / (max + min): 0.1 for a large filament, 1 for some LEDs (IEEE 1789).

    Parameters
    ----------
    frequency : float
        Hz.
    modulation : float
        0 to 1.
    phase : float
        Periods.

    Examples
    --------
    A lamp on mains of 50 Hz, whose light goes from 0.9 to 1.1:

    >>> light = sinusoid(100.0, 0.1)(np.linspace(0.0, 0.01, 101))
    >>> round(float(light.min()), 2), round(float(light.max()), 2)
    (0.9, 1.1)

    """
    turn = 2.0 * np.pi
    return lambda times: 1.0 + modulation * np.cos(turn * (frequency * times + phase))


def mean_over(waveform: Waveform, times: Times, length: float) -> Times:
    """Return the mean brightness over exposures of `length` s about each time."""
    parts = (np.arange(SLICES) + 0.5) / SLICES - 0.5
    return np.mean(waveform(np.expand_dims(times, -1) + length * parts), axis=-1)

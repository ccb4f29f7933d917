"""Lights that blink on their own time, free-running or coded, before a still wall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Pixels, SensorNoise
import numpy as np

SLICES = 64  # of an exposure; the part of it in which a light is on is known to one of them


@dataclass(frozen=True)
class Light:
    """
    A light.

    Parameters
    ----------
    x, y : float
        Place, px.
    sigma : float
        Standard deviation of its image, px.
    amplitude : float
        Peak above the background where it is on for the whole exposure, DN.
    on : callable
        From time, s, to whether it is on.

    """

    x: float
    y: float
    sigma: float
    amplitude: float
    on: Callable[[float], bool]


def periodic(frequency: float, duty: float, phase: float = 0.0) -> Callable[[float], bool]:
    """Return a light that is on for the part `duty` of each period; frequency in Hz."""
    return lambda time: (time * frequency + phase) % 1.0 < duty


def coded(bits: str, bit_time: float, start: float = 0.0) -> Callable[[float], bool]:
    """Return a light that repeats its bits, each for `bit_time` s."""
    return lambda time: bits[int((time - start) // bit_time) % len(bits)] == '1'


@dataclass(frozen=True)
class BlinkingLights:
    """
    Lights before an even wall, seen by a camera with an exposure of finite length.

    Parameters
    ----------
    lights : sequence of Light
        The lights.
    width, height : int
        Size of the frames, px.
    rate : float
        Frames a second.
    exposure : float
        Length of the exposure, as a part of the time between frames.
    background : float
        Level of the wall, DN.
    noise : SensorNoise
        Gain and read noise of the sensor.
    saturation : int
        Full scale of the sensor, DN.
    seed : int
        Of the noise.

    """

    lights: Sequence[Light]
    width: int = 160
    height: int = 120
    rate: float = 60.0
    exposure: float = 0.5
    background: float = 40.0
    noise: SensorNoise = SensorNoise(gain=40.0, read_noise=0.7)
    saturation: int = 255
    seed: int = 1

    def stamp_ns(self, index: int) -> int:
        """Return the middle of a frame's exposure, ns."""
        return 10**9 + round(1e9 * index / self.rate)

    def frame(self, index: int) -> Pixels:
        """Return the (h, w) pixels of a frame, DN: each light as bright as it was long on."""
        mean = np.full((self.height, self.width), self.background)
        length = self.exposure / self.rate
        times = self.stamp_ns(index) / 1e9 + length * ((np.arange(SLICES) + 0.5) / SLICES - 0.5)
        for light in self.lights:
            share = float(np.mean([light.on(float(time)) for time in times]))
            mean += share * light.amplitude * pixel_integrated_gaussian(
                mean.shape, light.x, light.y, light.sigma
            )
        random = np.random.Generator(np.random.SFC64([self.seed, index]))
        return expose(mean, self.noise, random, saturation=self.saturation)

"""A light that flashes on alternate frames and moves before a textured wall."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from blob_tracker.simulation.light import add_pulse
from blob_tracker.simulation.sensor import expose
from blob_tracker.simulation.truth import Truth
from blob_tracker.simulation.wall import textured_wall
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class FlashingLight:
    """
    Scene and camera together: gives the frame of any index, the same bits for the same seed.

    Parameters
    ----------
    width, height : int
        Size of the frames, px.
    rate : float
        Frames a second.
    sigma : float
        Standard deviation of the light's image, px.
    amplitude : float
        Its peak above the background, DN.
    background, texture : float
        Mean of the wall and standard deviation of its pattern, DN.
    reach : float
        Greatest distance of the path from the middle of the frame, as a part of its half-size.
    period : float
        Time in which the light goes across the frame and back, s.
    noise : SensorNoise
        Gain and read noise of the sensor.
    saturation : int
        Full scale of the sensor, DN.
    seed : int
        Of texture and noise.

    """

    width: int = 640
    height: int = 480
    rate: float = 60.0
    sigma: float = 2.0
    amplitude: float = 150.0
    background: float = 40.0
    texture: float = 8.0
    reach: float = 0.7
    period: float = 9.0
    noise: SensorNoise = SensorNoise(gain=40.0, read_noise=0.7)
    saturation: int = 255
    seed: int = 1

    @cached_property
    def wall(self) -> NDArray[np.float32]:
        """(h, w) mean signal of the unlit scene, DN: pattern of 1 to 16 px on a slope."""
        return textured_wall(
            (self.height, self.width),
            background=self.background,
            texture=self.texture,
            seed=self.seed,
        )

    def truth(self, index: int) -> Truth:
        """
        Return where the light is in a frame.

        The path is a Lissajous figure of the frequencies 2 and 3, which crosses the frame in all
        directions and visits every sub-pixel phase. The light is on in the even frames.
        """
        angle = 2.0 * np.pi * index / (self.rate * self.period)
        x = 0.5 * (self.width - 1) + self.reach * 0.5 * self.width * np.sin(2.0 * angle)
        y = 0.5 * (self.height - 1) + self.reach * 0.5 * self.height * np.sin(3.0 * angle + 0.5)
        return Truth(float(x), float(y), index % 2 == 0)

    def frame(self, index: int) -> Pixels:
        """
        Return the (h, w) pixels of a frame, DN.

        The exposure is taken to be short against the motion: the light stands still in it.
        """
        mean = self.wall
        x, y, lit = self.truth(index)
        if lit:
            mean = mean.copy()
            add_pulse(mean, x, y, self.sigma, self.amplitude)
        random = np.random.Generator(np.random.SFC64([self.seed, 1 + index]))
        return expose(mean, self.noise, random, saturation=self.saturation)

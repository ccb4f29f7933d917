"""A light that flashes on alternate frames and moves before a textured wall."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Pixels, SensorNoise
import cv2
import numpy as np
from numpy.typing import NDArray

REACH = 6.0  # sigma: beyond it the pulse is below 1e-7 of its peak


class Truth(NamedTuple):
    """Where the light is (px) and whether it is on in the frame."""

    x: float
    y: float
    lit: bool


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
        random = np.random.default_rng([self.seed, 0])
        pattern = np.zeros((self.height, self.width), dtype=np.float32)
        for scale in (1.0, 4.0, 16.0):
            white = random.standard_normal(pattern.shape, dtype=np.float32)
            layer = np.asarray(cv2.GaussianBlur(white, (0, 0), scale))
            pattern += layer / layer.std()
        slope = np.linspace(-0.5, 0.5, self.width, dtype=np.float32)
        wall = self.background * (1.0 + 0.5 * slope) + self.texture * pattern / np.sqrt(3.0)
        return np.maximum(wall, 0.0).astype(np.float32)

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
            half = int(np.ceil(REACH * self.sigma))
            column, row = round(x), round(y)
            left, top = max(column - half, 0), max(row - half, 0)
            bottom, right = row + half + 1, column + half + 1
            part = mean[top:bottom, left:right]
            if part.size:
                part += self.amplitude * pixel_integrated_gaussian(
                    part.shape, x - left, y - top, self.sigma
                ).astype(np.float32)
        random = np.random.Generator(np.random.SFC64([self.seed, 1 + index]))
        return expose(mean, self.noise, random, saturation=self.saturation)

"""
The scenes that are played into the driver's HDMI loop, with their truth.

A light that is on in every even frame, and two that blink by clocks of their own; still, textured
background; sensor noise. The paths are closed, and a file holds whole periods of all, so that a
player may repeat it for ever.
"""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation import (
    InterlacedCamera, Light, periodic, Scene as Simulated, Sensor, waveforms_of,
)
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
from vm.hdmi_loop import HEIGHT, SLOW_FRAME_RATE, WIDTH

FRAMES = 30
SIGMA = 2.0  # px
AMPLITUDE = 130.0  # DN on top of the background: the peak is near 150 DN
BACKGROUND = 20.0  # DN
NOISE = SensorNoise(gain=20.0, read_noise=0.7)
CENTRE = np.array([162.4, 116.8])  # px: the path crosses all four quadrants of the picture
RADII = np.array([61.3, 44.7])  # px
# The camera that looks at it, px: nothing equal, nothing in the middle.
FX, FY, CX, CY = 411.0, 397.0, 165.2, 113.7
# Of the lights that blink: bits of 1.2 frames and a wave of 4.2.
BLINK_FRAMES = 168  # 20 codes, 40 periods of the wave, once along the paths at 2 px a frame
CODE, BITS_PER_SECOND, FREQUENCY = '1101000', SLOW_FRAME_RATE / 1.2, SLOW_FRAME_RATE / 4.2
LIGHTS = 'coded', 'free'
EXPOSURE = 0.5 / SLOW_FRAME_RATE  # s
PAUSE = 4.5 / SLOW_FRAME_RATE  # s, from which on the lights are looked for anew
BLINK_WIDTH, BLINK_HEIGHT = 160, 120  # px
# An analogue camera by the standard of 625 lines, whose pictures are played into S-Video.
ANALOGUE_PICTURES, ANALOGUE_WIDTH, ANALOGUE_HEIGHT = 24, 720, 576


@dataclass(frozen=True)
class Scene:
    """
    Frames and where the light is in them.

    Parameters
    ----------
    frames : (n, h, w) uint8 array
        DN.
    lit : (n / 2, 2) array
        Place of the light in frames 0, 2, 4 ..., order x, y, px.

    """

    frames: NDArray[np.uint8]
    lit: NDArray[np.float64]


def flashing_scene(seed: int = 2) -> Scene:
    """Return the scene; the same seed gives the same bits."""
    random = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(FRAMES // 2) / (FRAMES // 2) + 0.1
    lit = CENTRE + RADII * np.column_stack([np.cos(angles), np.sin(angles)])
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    background = BACKGROUND + 6 * np.sin(x / 7) * np.cos(y / 5) + 4 * np.sin((x + y) / 23)
    frames = np.empty((FRAMES, HEIGHT, WIDTH), np.uint8)
    for index in range(FRAMES):
        mean = background
        if index % 2 == 0:
            place = lit[index // 2]
            pulse = pixel_integrated_gaussian((HEIGHT, WIDTH), place[0], place[1], SIGMA)
            mean = mean + AMPLITUDE * pulse
        frames[index] = expose(mean, NOISE, random)
    return Scene(frames, lit)


def blinking_lights() -> dict[str, Light]:
    """Return the coded light and the one that runs free, far from each other."""
    waveforms = waveforms_of(
        'coded', codes={'coded': CODE}, bits_per_second=BITS_PER_SECOND,
        frequencies={'free': FREQUENCY},
    )
    return {
        name: Light(
            x, y, SIGMA, AMPLITUDE, waveforms[name], 24.0, 14.0,
            period=BLINK_FRAMES / SLOW_FRAME_RATE, start=start,
        )
        for name, x, y, start in (('coded', 40.3, 62.6, 0.0), ('free', 117.8, 57.2, 0.3))
    }


def blinking_scene() -> Simulated:
    """Return both, exposed for half of the time between frames."""
    return Simulated(
        elements=tuple(blinking_lights().values()), width=BLINK_WIDTH, height=BLINK_HEIGHT,
        rate=SLOW_FRAME_RATE, background=BACKGROUND, texture=4.0, sensor=Sensor(NOISE),
        streaks=True, seed=3,
    )


def blinking_frames() -> NDArray[np.uint8]:
    """Return the (n, h, w) frames of it."""
    scene = blinking_scene()
    return np.array([scene.frame(index) for index in range(BLINK_FRAMES)], np.uint8)


def analogue_camera() -> InterlacedCamera:
    """Return a camera before a light in step with its pictures, on a closed path."""
    light = Light(
        361.3, 283.6, SIGMA, AMPLITUDE, periodic(12.5, 0.5, 0.125), 8.0, 5.0,
        period=ANALOGUE_PICTURES / 25.0)
    return InterlacedCamera(Simulated(
        light, width=ANALOGUE_WIDTH, height=ANALOGUE_HEIGHT, rate=50.0, exposure=0.1,
        background=BACKGROUND, texture=2.0, sensor=Sensor(NOISE), seed=4))


def analogue_frames() -> NDArray[np.uint8]:
    """Return the (n, h, w) interlaced pictures that it takes."""
    camera = analogue_camera()
    return np.array(
        [camera.picture(index).image for index in range(ANALOGUE_PICTURES)], np.uint8)


def packed_yuyv(luma: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return YUYV bytes: the luma with chroma of no colour (128)."""
    packed = np.full((*luma.shape, 2), 128, np.uint8)
    packed[..., 0] = luma
    return packed

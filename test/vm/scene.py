"""
The flashing scene that is played into the driver's HDMI loop, with its truth.

Light on in every even frame; still, textured background; sensor noise. The path is closed and
the count of frames even, so that a player may repeat it for ever.
"""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
from vm.hdmi_loop import HEIGHT, WIDTH

FRAMES = 30
SIGMA = 2.0  # px
AMPLITUDE = 130.0  # DN on top of the background: the peak is near 150 DN
BACKGROUND = 20.0  # DN
NOISE = SensorNoise(gain=20.0, read_noise=0.7)
CENTRE = np.array([162.4, 116.8])  # px: the path crosses all four quadrants of the picture
RADII = np.array([61.3, 44.7])  # px
# The camera that looks at it, px: nothing equal, nothing in the middle.
FX, FY, CX, CY = 411.0, 397.0, 165.2, 113.7


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


def packed_yuyv(luma: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return YUYV bytes: the luma with chroma of no colour (128)."""
    packed = np.full((*luma.shape, 2), 128, np.uint8)
    packed[..., 0] = luma
    return packed

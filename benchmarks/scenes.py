"""Synthetic windows with the truth kept, and the bound that goes with them."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.bound import bound
from benchmarks.windows import clipped, Windows
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise
import cv2
import numpy as np
from numpy.typing import NDArray

SENSOR = SensorNoise(gain=20.0, read_noise=0.25)  # 20 e-/DN, 5 e- of read noise
FULL_SCALE = 4095  # DN, 12 bit
BACKGROUND = 20.0  # DN
PLACES = 1024  # sub-pixel places a scene: ample, and each is computed once
BOUNDS = 100  # places over which the bound is averaged
TEXTURE_CORRELATION = 1.5  # px


@dataclass(frozen=True)
class Scene:
    """
    One kind of window.

    Parameters
    ----------
    window : int
        Side, px.
    sigma : float
        Standard deviation of the blob, px (geometric mean of the axes).
    snr : float
        Amplitude over the standard deviation of a pixel at the peak.
    noise : SensorNoise
        The sensor.
    background : float
        Ambient light, DN.
    axis_ratio : float
        sigma_x / sigma_y.
    texture : float or None
        Standard deviation of the ambient light over the window, relative to its mean; None
        if there is no unlit window.
    overexposure : float
        Amplitude over full scale; 0 where full scale is out of reach. Above 0 it sets the
        full scale, the amplitude staying that of the SNR.

    """

    window: int
    sigma: float
    snr: float
    noise: SensorNoise = SENSOR
    background: float = BACKGROUND
    axis_ratio: float = 1.0
    texture: float | None = None
    overexposure: float = 0.0


@dataclass(frozen=True)
class Sample:
    """
    Windows of a scene with the truth.

    Parameters
    ----------
    windows : Windows
        What a contender sees.
    x, y : (N,) arrays
        True places, px.
    bound : float
        Root of the mean of the bounds of x and y over the places, px.

    """

    windows: Windows
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    bound: float


def amplitude(scene: Scene) -> float:
    """Return the DN at which A^2 = SNR^2 ((A + b) / gain + read_noise^2 + 1/12)."""
    square = scene.snr**2
    linear = square / scene.noise.gain
    fixed = square * (scene.background / scene.noise.gain + scene.noise.read_noise**2 + 1 / 12)
    return linear / 2 + float(np.sqrt(linear**2 / 4 + fixed))


def sample(
    scene: Scene, count: int, seed: int, places: NDArray[np.float64] | None = None
) -> Sample:
    """
    Expose `count` windows of the scene.

    Parameters
    ----------
    scene : Scene
        What to expose.
    count : int
        How many windows.
    seed : int
        State of the noise and of the places.
    places : (P, 2) array or None
        Places x, y relative to the window's middle, px, taken in turn; None draws them evenly
        over one pixel.

    """
    random = np.random.default_rng(seed)
    if places is None:
        places = random.uniform(-0.5, 0.5, (min(count, PLACES), 2))
    centres = places + (scene.window - 1) / 2
    shape = (scene.window, scene.window)
    level = amplitude(scene)
    sigma_x = scene.sigma * np.sqrt(scene.axis_ratio)
    sigma_y = scene.sigma / np.sqrt(scene.axis_ratio)
    pulses = np.stack(
        [pixel_integrated_gaussian(shape, x, y, sigma_x, sigma_y) for x, y in centres]
    )
    turn = np.arange(count) % len(centres)
    ambient = _ambient(scene, count, random)
    full_scale = FULL_SCALE
    if scene.overexposure > 0.0:
        full_scale = round(level / scene.overexposure)
    exposed = [
        expose(mean, scene.noise, random, saturation=full_scale)
        for mean in (ambient + level * pulses[turn], ambient)
    ]
    windows = Windows(
        exposed[0],
        None if scene.texture is None else exposed[1],
        scene.noise,
        full_scale,
        scene.sigma,
    )
    used = ~clipped(windows)
    bounds = [
        bound(
            shape,
            np.array([*centres[turn[index]], sigma_x, sigma_y, level, scene.background]),
            scene.noise,
            unlit=None if scene.texture is None else ambient[index],
            used=used[index],
            elliptical=scene.axis_ratio != 1.0,
        )
        for index in range(min(count, BOUNDS))
    ]
    x, y = centres[turn].T
    return Sample(windows, x, y, float(np.sqrt(np.mean([np.trace(b) / 2 for b in bounds]))))


def _ambient(scene: Scene, count: int, random: np.random.Generator) -> NDArray[np.float64]:
    """Return (count, h, w) DN of ambient light: even, or with a random texture of its own."""
    even = np.full((count, scene.window, scene.window), scene.background)
    if not scene.texture:
        return even
    grain = random.standard_normal(even.shape)
    smooth = np.stack([cv2.GaussianBlur(field, (0, 0), TEXTURE_CORRELATION) for field in grain])
    smooth /= smooth.std()
    return np.maximum(even * (1.0 + scene.texture * smooth), 0.0)

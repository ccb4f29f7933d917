"""A webcam of 8 bits with the gamma of television, and the response that undoes it."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.camera.response import Response
from blob_tracker.simulation import in_step, Light, Scene, Sensor
from blob_tracker.types import SensorNoise
import cv2
import numpy as np
from numpy.typing import NDArray

GAMMA = 0.45
NOISE = SensorNoise(20.0, 0.3)  # of the sensor before the curve, in DN of 255
WIDTH, HEIGHT = 128, 96  # px
FINENESS = 16.0  # linear DN in a DN of 255


def light_of(raw: NDArray[np.generic] | float) -> NDArray[np.float64]:
    """Return the light for raw DN, in DN of 255."""
    return np.asarray(255.0 * (np.asarray(raw, dtype=float) / 255.0) ** (1.0 / GAMMA))


def gamma_response(width: int = WIDTH, height: int = HEIGHT) -> Response:
    """Return the true response."""
    levels = np.linspace(0.0, 255.0, 52)
    return Response(levels, FINENESS * light_of(levels), np.zeros(52), width, height)


def linear_noise() -> SensorNoise:
    """Return the noise of linear pixels: that of the sensor, and of rounding after the curve."""
    raw = np.arange(1.0, 256.0)
    light = light_of(raw)
    step = light / raw / GAMMA
    variance = light / NOISE.gain + NOISE.read_noise**2 + step**2 / 12.0
    slope, foot = np.polyfit(light, variance, 1, w=1.0 / variance)
    return SensorNoise(float(1.0 / slope) / FINENESS, float(np.sqrt(foot)) * FINENESS)


def gamma_scene(peak: float, background: float, *, moving: bool = False) -> Scene:
    """Return a flashing light whose raw peak and background are these, DN."""
    dark = float(light_of(background))
    light = Light(
        64.3, 48.2, 1.5, float(light_of(peak)) - dark, in_step(60.0),
        reach_x=20.0 if moving else 0.0, reach_y=12.0 if moving else 0.0,
    )
    return Scene(
        width=WIDTH, height=HEIGHT, background=dark, target=light, texture=0.0,
        sensor=Sensor(NOISE, gamma=GAMMA),
    )


def rec709(light: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the raw DN of light in DN of 255: ITU-R BT.709, a power with a straight foot."""
    part = np.clip(np.asarray(light) / 255.0, 0.0, 1.0)
    return np.asarray(255.0 * np.where(part < 0.018, 4.5 * part, 1.099 * part**0.45 - 0.099))


def limited(light: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the raw DN of a linear camera of 16 to 235 DN."""
    return np.asarray(16.0 + 219.0 * np.clip(np.asarray(light) / 255.0, -16.0 / 219.0, 1.0))


CURVES: dict[str, Callable[[NDArray[np.floating]], NDArray[np.float64]]] = {
    'rec709': rec709, 'limited': limited,
}


def seen(
    curve: str, light: NDArray[np.floating], random: np.random.Generator,
    noise: SensorNoise = NOISE,
) -> NDArray[np.uint8]:
    """Return a frame of a camera with a curve; light in DN of 255."""
    variance = np.maximum(light, 0.0) / noise.gain + noise.read_noise**2
    signal = light + np.sqrt(variance) * random.standard_normal(np.shape(light))
    return np.clip(np.rint(CURVES[curve](signal)), 0, 255).astype(np.uint8)


def still_scene(height: int, width: int) -> NDArray[np.float64]:
    """Return a scene of soft bright and dark parts, its brightest one at 20 DN of 255."""
    random = np.random.default_rng(5)
    soft = cv2.GaussianBlur(random.uniform(size=(height, width)), (0, 0), 10)
    part = (soft - soft.min()) / np.ptp(soft)
    return np.asarray(20.0 * (0.03 + 0.97 * part**2))

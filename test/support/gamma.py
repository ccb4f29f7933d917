"""A webcam of 8 bits with the gamma of television, and the response that undoes it."""

from __future__ import annotations

from blob_tracker.camera.response import Response
from blob_tracker.simulation import in_step, Light, Scene, Sensor
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

GAMMA = 0.45
NOISE = SensorNoise(20.0, 0.3)  # of the sensor before the curve, in DN of 255
WIDTH, HEIGHT = 128, 96  # px
FINENESS = 16.0  # linear DN in a DN of 255


def light_of(raw: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return the light for raw DN, in DN of 255."""
    return np.asarray(255.0 * (np.asarray(raw) / 255.0) ** (1.0 / GAMMA))


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
    reach = {'reach_x': 20.0, 'reach_y': 12.0} if moving else {}
    light = Light(64.3, 48.2, 1.5, float(light_of(peak)) - dark, in_step(60.0), **reach)
    return Scene(
        width=WIDTH, height=HEIGHT, background=dark, target=light, texture=0.0,
        sensor=Sensor(NOISE, gamma=GAMMA),
    )

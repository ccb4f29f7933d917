"""Pulses that are no Gaussians, windows of them with noise, and the bound of their places."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.location.noise import pixel_variance
from blob_tracker.types import SensorNoise
import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates, spline_filter

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
PEAK, BACKGROUND = 120.0, 30.0
FINE = 11  # points a pixel, odd: a box of them has a middle

Pulse = Callable[[float, float], np.ndarray]


def drawn(
    side: int, intensity: Callable[[np.ndarray, np.ndarray], np.ndarray], blur: float = 0.7
) -> Pulse:
    """Return the pulse of an intensity by offset, px, blurred by so many px and by the pixel."""
    span = np.arange(-side * FINE, side * FINE + 1) / FINE
    surface = gaussian_filter(intensity(span[None, :], span[:, None]).astype(float), blur * FINE)
    box = np.full(FINE, 1.0 / FINE)
    for axis in range(2):
        surface = np.apply_along_axis(np.convolve, axis, surface, box, 'same')
    middle = (side - 1) / 2
    coefficients = spline_filter(surface, order=3)

    def pulse(x: float, y: float) -> np.ndarray:
        rows = (np.arange(side) - y) * FINE + side * FINE
        columns = (np.arange(side) - x) * FINE + side * FINE
        return map_coordinates(
            coefficients, np.meshgrid(rows, columns, indexing='ij'), order=3, prefilter=False
        )

    assert pulse(middle, middle).max() > 0.3
    return pulse


def shots(random: np.random.Generator, mean: np.ndarray) -> np.ndarray:
    """Return whole DN with the noise of NOISE."""
    electrons = random.poisson(mean * NOISE.gain)
    return np.round(electrons / NOISE.gain + random.normal(0.0, NOISE.read_noise, mean.shape))


def windows(pulse: Pulse, side: int, seed: int, count: int):
    """Return lit and unlit windows and the places, in all phases."""
    random = np.random.default_rng(seed)
    places = (side - 1) / 2 + random.uniform(-1.0, 1.0, (count, 2))
    mean = np.stack([BACKGROUND + PEAK * pulse(*place) for place in places])
    return shots(random, mean), shots(random, np.full(mean.shape, BACKGROUND)), places


def bound(pulse: Pulse, side: int) -> float:
    """Return the rms that x and y can have at best, px: amplitude and background unknown."""
    middle, step = (side - 1) / 2 + 0.2, 0.02
    light = pulse(middle, middle)
    slopes = [
        PEAK * (pulse(middle + step, middle) - pulse(middle - step, middle)) / (2 * step),
        PEAK * (pulse(middle, middle + step) - pulse(middle, middle - step)) / (2 * step),
        light, np.ones_like(light),
    ]
    weight = 1.0 / pixel_variance(BACKGROUND + PEAK * light, NOISE)
    fisher = np.array([[(a * b * weight).sum() for b in slopes] for a in slopes])
    # The unlit window has the background as well.
    fisher[3, 3] += side**2 / float(pixel_variance(np.array(BACKGROUND), NOISE))
    return float(np.sqrt(np.trace(np.linalg.inv(fisher)[:2, :2]) / 2))

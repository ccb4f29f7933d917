"""Windows of lights that are no round pulse, and how their places hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from blob_tracker.location import locate_batch
from blob_tracker.location.estimates import Estimates
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
BACKGROUND, PEAK, SIGMA = 30.0, 120.0, 1.5  # DN, DN, px
Light = Callable[[tuple[int, int], float, float], NDArray[np.float64]]


@dataclass(frozen=True)
class Located:
    """What came of the windows of a light."""

    found: Estimates
    errors: NDArray[np.float64]

    @property
    def nees(self) -> float:
        """Mean of e^T C^-1 e: 2 where the covariance is true."""
        solved = np.linalg.solve(self.found.covariance, self.errors[:, :, None])[:, :, 0]
        return float((self.errors * solved).sum(axis=1).mean())

    @property
    def rms(self) -> float:
        """Along one axis, px."""
        return float(np.sqrt((self.errors**2).mean()))

    def said(self, words: str) -> float:
        """Return the share of the windows whose warning has these words."""
        return sum(words in each for each in self.found.warnings.values()) / len(self.errors)


def located(
    light: Light, size: int, count: int, *, noise: SensorNoise = NOISE, saturation: int = 4095
) -> Located:
    """Draw, expose and locate so many lights, each at a place of its own."""
    random = np.random.default_rng(7)
    places = (size - 1) / 2 + random.uniform(-0.5, 0.5, (count, 2))
    lit = np.stack([
        expose(light((size, size), x, y) + BACKGROUND, NOISE, random, saturation=saturation)
        for x, y in places
    ])
    unlit = np.stack([
        expose(np.full((size, size), BACKGROUND), NOISE, random) for _ in places
    ])
    found = locate_batch(lit, unlit, noise=noise, saturation=saturation)
    assert found.ok.all()
    return Located(found, np.stack([found.x, found.y], axis=1) - places)


def pulse(shape: tuple[int, int], x: float, y: float) -> NDArray[np.float64]:
    """Return a round pulse."""
    return PEAK * pixel_integrated_gaussian(shape, x, y, SIGMA)


def dragged(
    shape: tuple[int, int], x: float, y: float, way: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the mean of a pulse on its way from (x, y), px."""
    steps = (np.arange(41) + 0.5) / 41
    return np.mean([pulse(shape, x + t * way[0], y + t * way[1]) for t in steps], axis=0)

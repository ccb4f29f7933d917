"""Noisy windows with the truth kept, for the tests of the location room."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from blob_tracker.location import Estimates, locate_batch
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.stats import chi2


@dataclass(frozen=True)
class Scene:
    """N windows of one pulse at random sub-pixel places."""

    lit: NDArray[np.generic]
    unlit: NDArray[np.generic] | None
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    noise: SensorNoise
    saturation: int

    def locate(self, method: str, **options: Any) -> Estimates:
        """Locate every window by a method."""
        return locate_batch(
            self.lit, self.unlit, method=method, noise=self.noise,
            saturation=self.saturation, **options,
        )

    def errors(self, found: Estimates) -> NDArray[np.float64]:
        """Return the (M, 2) errors of the windows that were located."""
        return np.stack([found.x - self.x, found.y - self.y], axis=1)[found.ok]


@pytest.fixture
def scene() -> Callable[..., Scene]:
    """Return the maker of scenes."""
    return make_scene


def make_scene(
    size: int,
    sigma: float,
    amplitude: float,
    *,
    count: int,
    noise: SensorNoise,
    sigma_y: float | None = None,
    background: float = 20.0,
    texture: NDArray[np.float64] | float = 0.0,
    unlit: bool = False,
    saturation: int = 4095,
    seed: int = 1,
) -> Scene:
    """Expose `count` windows of size x size px with a pulse within half a pixel of the middle."""
    random = np.random.default_rng(seed)
    x, y = (size - 1) / 2 + random.uniform(-0.5, 0.5, (2, count))
    down = integrated_profile(size, y, sigma if sigma_y is None else sigma_y)[0]
    across = integrated_profile(size, x, sigma)[0]
    behind = np.broadcast_to(background + texture, (count, size, size))
    lit = expose(
        amplitude * down[:, :, None] * across[:, None, :] + behind, noise, random,
        saturation=saturation,
    )
    dark = expose(behind, noise, random, saturation=saturation) if unlit else None
    return Scene(lit, dark, x, y, noise, saturation)


@pytest.fixture
def nees_bounds() -> Callable[[int], tuple[float, float]]:
    """Return the 95 % bounds of the mean of `count` squares of chi with two degrees each."""

    def bounds(count: int) -> tuple[float, float]:
        low, high = chi2.ppf([0.025, 0.975], 2 * count) / count
        return float(low), float(high)

    return bounds

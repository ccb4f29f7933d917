"""What the last flashes tell of a streak: how far its light is off the middle of a bent path."""

from __future__ import annotations

from collections.abc import Callable
import math

from blob_tracker.location import Locator
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
PEAK, SIGMA, BACKGROUND, SIZE, COUNT = 2000.0, 1.5, 30.0, 27, 60  # DN, px, DN, px, flashes
FLASH_S, EXPOSURE_S = 1 / 30, 0.45 / 30
Path = Callable[[float], complex]


def circle(radius: float, speed: float) -> Path:
    """Return a path about a place with so many px a flash."""
    turn = speed / radius / FLASH_S
    return lambda t: 200.0 + 150.0j + radius * complex(math.cos(turn * t), math.sin(turn * t))


def straight(speed: float) -> Path:
    """Return a path that bends nowhere."""
    return lambda t: 50.0 + 150.0j + speed * complex(0.8, 0.6) * t / FLASH_S


def errors(path: Path) -> tuple[float, float]:
    """Return the NEES of a light's places from the sixth on, and their largest error, px."""
    random = np.random.default_rng(4)
    locator, squares, far = Locator(), [], []
    for n in range(COUNT):
        middle = path(n * FLASH_S)
        left, top = round(middle.real) - SIZE // 2, round(middle.imag) - SIZE // 2
        way = [path(n * FLASH_S + u * EXPOSURE_S) for u in (np.arange(24) + 0.5) / 24 - 0.5]
        light = np.mean([
            pixel_integrated_gaussian((SIZE, SIZE), each.real - left, each.imag - top, SIGMA)
            for each in way
        ], axis=0)
        dark = np.full((SIZE, SIZE), BACKGROUND)
        window = Window(
            expose(dark + PEAK * light, NOISE, random, saturation=4095),
            expose(dark, NOISE, random, saturation=4095), left, top, round(n * FLASH_S * 1e9),
            4095,
        )
        location = locator.locate(window, noise=NOISE)
        error = np.array([location.x - middle.real, location.y - middle.imag])
        squares.append(float(error @ np.linalg.solve(location.covariance, error)))
        far.append(float(np.hypot(*error)))
    return float(np.mean(squares[5:])), max(far[5:])


@pytest.mark.parametrize('radius, speed', [(20.0, 10.0), (45.0, 14.0)])
def test_the_light_of_a_bent_streak_is_off_its_middle(radius: float, speed: float) -> None:
    """By l^2 / (24 R), 0.04 px of each, seven sigma; of 110 errors the NEES is known to 0.27."""
    lag = (speed * EXPOSURE_S / FLASH_S) ** 2 / (24.0 * radius)
    consistency, farthest = errors(circle(radius, speed))
    assert lag > 0.035
    assert farthest < lag
    assert 0.7 < consistency < 2.8


def test_a_straight_one_is_placed_as_before() -> None:
    """Its last places tell that it does not bend."""
    consistency, _ = errors(straight(12.0))
    assert 1.3 < consistency < 2.8

"""What the last flashes tell of a light: its bent path, its lean and its flicker."""

from __future__ import annotations

from collections.abc import Callable
import math

from blob_tracker.location import Locator
from blob_tracker.location.flash_memory import (
    FlashMemory, LOPSIDED_FLASHES, REMEMBERED, SUMMED,
)
from blob_tracker.location.suspicion import HEAD
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Location, SensorNoise, Window
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


def told(memory: FlashMemory, scores: np.ndarray, light: float, k: int) -> None:
    """Have a light that stands, of so much light, take a flash with these scores."""
    location = Location(
        100.0, 80.0, 1e-4 * np.eye(2), light, BACKGROUND, 1.0, 50.0, 1.0, 0, k * 33_000_000)
    memory.add(location, {}, lopsided=scores.tolist())


def test_the_last_flashes_alone_tell_that_a_light_is_lopsided() -> None:
    """Sum as many as are remembered, and forget those before them."""
    memory, random = FlashMemory(), np.random.default_rng(7)
    count = SUMMED + 40
    scores = np.column_stack([random.normal(0.5, 1.0, (count, 2)), np.ones((count, 2))])
    doubted = 0
    for k, each in enumerate(scores):
        told(memory, each, 100.0, k)
        score_x, score_y, x, y = scores[max(k + 1 - SUMMED, 0):k + 1].sum(axis=0)
        leaning = score_x**2 / x + score_y**2 / y
        assert (memory.doubt is not None) == (leaning >= LOPSIDED_FLASHES)
        if memory.doubt is not None:
            head = HEAD * np.array([score_x / x, score_y / y])
            expected = (1.0 - 2.0 / leaning) * np.outer(head, head)
            # What was added and taken off again leaves the rounding of a hundred sums.
            np.testing.assert_allclose(memory.doubt, expected, rtol=1e-9)
            doubted += 1
    assert 0 < doubted < len(scores)


def test_the_last_flashes_alone_tell_of_a_flicker() -> None:
    """It is that of the differences between them, of which three quarters are as large or less."""
    memory, random = FlashMemory(), np.random.default_rng(8)
    lights = np.full(3 * REMEMBERED, 100.0)
    lights[:REMEMBERED] = random.uniform(20.0, 180.0, REMEMBERED)
    for k, light in enumerate(lights):
        told(memory, np.array([0.0, 0.0, 1.0, 1.0]), light, k)
        last = lights[max(k + 1 - REMEMBERED, 0):k + 1]
        if len(last) < 4:
            assert memory.flicker == 0.0
            continue
        differences = np.sort(np.abs(np.diff(last)))
        expected = differences[3 * len(differences) // 4] / last.mean()
        # That of noise, 5 sigma of 1/50, is below each of these.
        assert memory.flicker == pytest.approx(expected if expected > 0.1 else 0.0)
    assert memory.flicker == 0.0

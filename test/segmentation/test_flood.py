"""A flood light in step with the frames is no target, and neither is what it lights up."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise
import cv2
import numpy as np
import pytest

SHAPE = (96, 128)
NOISE = SensorNoise(gain=10.0, read_noise=1.0)


def room(random: np.random.Generator) -> np.ndarray:
    """Return what a room reflects, mean 1: walls, furniture, small bright things."""
    out = np.ones(SHAPE)
    for scale, rough in ((1.5, 0.08), (6.0, 0.15), (25.0, 0.3)):
        field = cv2.GaussianBlur(random.standard_normal(SHAPE), (0, 0), scale)
        out *= np.exp(rough * field / field.std())
    for _ in range(5):
        left, top, wide, high = random.integers((0, 0, 8, 8), (108, 76, 40, 40))
        out[top:top + high, left:left + wide] *= random.uniform(0.3, 2.0)
    for _ in range(12):
        x, y = random.uniform((5, 5), (123, 91))
        out += random.uniform(0.2, 1.5) * pixel_integrated_gaussian(
            SHAPE, x, y, random.uniform(1.0, 4.0)
        )
    return out / out.mean()


def seen(level: float, dark: float, light: float, seed: int) -> tuple[int, list[str]]:
    """Return how many windows 30 flashes of a flood give, and what is said of the others."""
    random = np.random.default_rng(seed)
    unlit = np.full(SHAPE, dark)
    lit = dark + level * room(random) + light * pixel_integrated_gaussian(SHAPE, 70.3, 40.2, 1.5)
    segmenter = Segmenter()
    found, reasons = 0, []
    for index in range(60):
        image = expose(unlit if index % 2 else lit, NOISE, random)
        window = segmenter.update(Frame(image, 1 + index * 10**7, 255))
        if window is not None:
            found += 1
        elif index > 0 and index % 2 == 0:
            reasons.append(segmenter.reason)
    return found, reasons


@pytest.mark.parametrize('level', [20.0, 40.0, 80.0])
@pytest.mark.parametrize('dark', [0.0, 2.0, 5.0])
def test_a_flooded_room_gives_no_window(level: float, dark: float) -> None:
    """And is named."""
    for seed in range(3):
        found, reasons = seen(level, dark, 0.0, seed)
        assert found == 0
        assert sum('flood light' in each for each in reasons) >= 0.9 * len(reasons)


def test_a_light_in_a_flooded_room_is_found() -> None:
    """A retro-reflector, ten times as bright as the walls."""
    for seed in range(3):
        assert seen(15.0, 2.0, 150.0, seed)[0] >= 25

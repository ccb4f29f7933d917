"""Lights are as bright in a frame as they were long on during its exposure."""

from blob_tracker.simulation import BlinkingLights, coded, Light, periodic
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SILENT = SensorNoise(gain=np.inf, read_noise=0.0)


def peaks(light: Light, frames: int, exposure: float) -> list[int]:
    """Return the brightest pixel of each frame."""
    scene = BlinkingLights([light], rate=50.0, exposure=exposure, background=0.0, noise=SILENT)
    return [int(scene.frame(index).max()) for index in range(frames)]


def test_a_light_on_for_half_the_exposure_is_half_as_bright() -> None:
    """The edge runs through the middle of every second exposure."""
    light = Light(80.0, 60.0, 5.0, 200.0, periodic(25.0, 0.5))
    # 200 DN in the middle; the mean over a pixel is 0.3 % below it.
    assert peaks(light, 4, 1.0) == pytest.approx([100] * 4, abs=2)
    light = Light(80.0, 60.0, 5.0, 200.0, periodic(25.0, 0.5, phase=0.25))
    assert peaks(light, 4, 1.0) == pytest.approx([199, 0, 199, 0], abs=4)


def test_a_code_is_seen_bit_by_bit() -> None:
    """One bit a frame, over and over."""
    light = Light(80.0, 60.0, 5.0, 200.0, coded('1101000', 0.02, start=-0.01))
    bits = ''.join('1' if peak > 100 else '0' for peak in peaks(light, 14, 0.5))
    assert bits in 2 * 2 * '1101000'

"""Lights are as bright in a frame as they were on the mean of its exposure."""

from blob_tracker.simulation import coded, Light, periodic, Scene, Sensor, sinusoid
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SILENT = Sensor(SensorNoise(gain=np.inf, read_noise=0.0), bits=12)


def peaks(light: Light, frames: int, exposure: float, rate: float = 50.0) -> list[int]:
    """Return the brightest pixel of each frame."""
    scene = Scene(
        light, width=160, height=120, rate=rate, exposure=exposure, background=0.0, texture=0.0,
        sensor=SILENT,
    )
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


@pytest.mark.parametrize('rate, frames', [(60.0, 3), (40.0, 2), (50.0, 1)])
def test_a_mains_lamp_is_seen_at_its_alias(rate: float, frames: int) -> None:
    """100 Hz repeats after 3 frames at 60 a second, after 2 at 40, and stands still at 50."""
    seen = peaks(Light(80.0, 60.0, 5.0, 1000.0, sinusoid(100.0, 0.8)), 12, 0.3, rate)
    assert seen[frames:] == pytest.approx(seen[:-frames], abs=2)
    if frames > 1:
        assert max(seen) - min(seen) > 300


@pytest.mark.parametrize('exposure', [0.1, 0.3, 0.6])
def test_a_longer_exposure_evens_the_flicker_out(exposure: float) -> None:
    """By sinc(f T): 100 Hz over a part of 1/40 s."""
    high, low = peaks(Light(80.0, 60.0, 5.0, 1000.0, sinusoid(100.0, 0.8)), 2, exposure, 40.0)
    modulation = (high - low) / (high + low)
    # Of 1000 DN each is rounded to 1.
    assert modulation == pytest.approx(0.8 * np.sinc(100.0 * exposure / 40.0), abs=0.002)


def test_path_is_closed_and_reaches_as_far_as_said() -> None:
    """Back at its beginning after a period."""
    light = Light(80.0, 60.0, 2.0, 1.0, reach_x=30.0, reach_y=10.0, period=4.0)
    assert light.spot(4.0) == pytest.approx(light.spot(0.0))
    places = np.array([light.spot(time)[:2] for time in np.linspace(0.0, 4.0, 2001)])
    assert np.abs(places - (80.0, 60.0)).max(axis=0) == pytest.approx((30.0, 10.0), abs=0.01)

"""The light on a scene: even with a global shutter, bands with a rolling one."""

from blob_tracker.simulation import AmbientLight, periodic, Scene, Sensor, sinusoid
import numpy as np
import pytest


def rows(
    light: AmbientLight, index: int, exposure: float = 0.1, sensor: Sensor = Sensor()
) -> np.ndarray:
    """Return what it makes of each row of a picture of 1."""
    picture = np.ones((480, 4), dtype=np.float32)
    light.draw(picture, Scene(rate=50.0, exposure=exposure, sensor=sensor).shot(index))
    assert (picture == picture[:, :1]).all()
    return picture[:, 0]


def test_a_global_shutter_sees_all_rows_alike() -> None:
    """A light that is switched at 25 Hz."""
    light = AmbientLight(periodic(25.0, 0.5, phase=0.25))
    assert rows(light, 0) == pytest.approx(1.0, abs=1e-5)
    assert rows(light, 1) == pytest.approx(0.0, abs=1e-5)


def test_a_rolling_shutter_shows_bands() -> None:
    """Each row has the mean over its own exposure: f readout / rate bands, sinc(f T) deep."""
    frequency, readout, exposure = 120.0, 0.8, 0.1
    sensor = Sensor(row_time=readout / (50.0 * 480))
    found = rows(AmbientLight(sinusoid(frequency, 0.5)), 3, exposure, sensor)
    times = (3 + readout * ((np.arange(480) + 0.5) / 480 - 0.5)) / 50.0
    depth = 0.5 * np.sinc(frequency * exposure / 50.0)
    expected = 1.0 + depth * np.cos(2.0 * np.pi * frequency * times)
    # 64 steps to an exposure of a quarter period, linear between them.
    assert found == pytest.approx(expected, abs=1e-3)

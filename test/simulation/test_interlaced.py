"""An interlaced camera: each field has its lines and its time."""

from __future__ import annotations

from blob_tracker.capture.fields import fields
from blob_tracker.simulation import InterlacedCamera, Light, Scene, Sensor
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

RATE = 50.0  # fields/s
QUIET = Sensor(SensorNoise(gain=np.inf, read_noise=0.0), bits=16)


def scene(reach: float = 0.0) -> Scene:
    """Return a light on a dark night."""
    light = Light(40.3, 30.7, 2.0, 10_000.0, reach_x=reach, reach_y=reach, period=4.0)
    return Scene(
        light, width=80, height=60, rate=RATE, exposure=0.05, background=0.0, texture=0.0,
        sensor=QUIET,
    )


@pytest.mark.parametrize('order', ['interlaced_tb', 'interlaced_bt'])
def test_fields_show_the_light_where_it_was_at_their_stamps(order: str) -> None:
    """In px of the scene, in either order."""
    camera = InterlacedCamera(scene(15.0), order)
    for index in (0, 3):
        for field in fields(camera.picture(index), order, camera.interval_ns):
            light = field.image.astype(float)
            rows, columns = np.indices(light.shape)
            x, y = (float((light * each).sum() / light.sum()) for each in (columns, rows))
            truth = camera.scene.target.spot((field.stamp_ns - 1e9) / 1e9)
            # Rounded to a part in ten thousand of the light.
            assert x == pytest.approx(truth.x, abs=1e-3)
            assert field.y0 + 2.0 * (y + 0.5) - 0.5 == pytest.approx(truth.y, abs=1e-3)


def test_the_lines_are_those_of_the_chain() -> None:
    """The odd ones lie to the right of the even ones by what it says."""
    camera = InterlacedCamera(scene(), chain=AnalogueChain(between_fields=0.5))
    light = camera.picture(0).image[26:36].astype(float)
    places = light @ np.arange(80.0) / light.sum(axis=1)
    # Cubic splines displace a blob of 2 px to a thousandth.
    assert places[1::2] == pytest.approx(40.8, abs=2e-3)
    assert places[::2] == pytest.approx(40.3, abs=2e-3)


def test_another_order_is_refused() -> None:
    """A camera's fields are woven by its grabber, if at all."""
    with pytest.raises(ValueError, match='interlaced_tb or interlaced_bt'):
        InterlacedCamera(scene(), 'seq_tb')

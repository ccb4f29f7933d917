"""The sun is a clipped disc that moves with the picture."""

from blob_tracker.simulation import Scene, Sensor, Stepping, SunDisc
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SCENE = Scene(
    elements=(SunDisc(80.0, 60.0, radius=12.0),),
    camera=Stepping(7.0, -4.0),
    width=160,
    height=120,
    texture=0.0,
    background=20.0,
    sensor=Sensor(SensorNoise(gain=np.inf, read_noise=0.0)),
)


@pytest.mark.parametrize('index, x, y', [(1, 80.0, 60.0), (2, 87.0, 56.0)])
def test_disc_is_clipped_at_its_place(index: int, x: float, y: float) -> None:
    """Of the area pi r^2, but for the rim: the glare and the limb's foot add half a pixel."""
    clipped = SCENE.frame(index) == 255
    assert np.sqrt(clipped.sum() / np.pi) == pytest.approx(12.25, abs=0.35)
    rows, columns = np.nonzero(clipped)
    assert (columns.mean(), rows.mean()) == pytest.approx((x, y), abs=0.05)


def test_glare_falls_with_the_distance() -> None:
    """To nothing, without an edge."""
    row = SCENE.frame(1)[60].astype(float)
    glare = row[94:] - 20.0 * (1.0 + 0.5 * np.linspace(-0.5, 0.5, 160)[94:])
    assert glare[0] > 35.0
    assert (np.diff(glare) < 1.5).all() and np.diff(glare).min() < -3.0
    assert SCENE.frame(1)[60, :2].mean() < 20.0


def test_out_of_the_picture_it_does_no_harm() -> None:
    """Beyond any border."""
    for x, y in ((-500.0, 60.0), (80.0, 900.0), (-5.0, -5.0)):
        picture = np.zeros((120, 160), dtype=np.float32)
        SunDisc(x, y).draw(picture, SCENE.shot(1))
        assert np.isfinite(picture).all()
        assert (picture.max() > 0.0) == (x == -5.0)

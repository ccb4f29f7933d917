"""The picture moves as it is said to, and the light with it."""

from blob_tracker.simulation import FlashingLight, MovingCamera
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SILENT = SensorNoise(gain=np.inf, read_noise=0.0)


def test_wall_moves_by_whole_pixels_as_a_roll() -> None:
    """Three to the right and two up in the lit frame, nothing interpolated."""
    scene = FlashingLight(width=120, height=90, amplitude=0.0, noise=SILENT)
    camera = MovingCamera(scene, shift_x=3.0, shift_y=-2.0)
    np.testing.assert_array_equal(camera.frame(2)[:-2, 3:], camera.frame(1)[2:, :-3])


def test_light_stands_where_the_truth_says() -> None:
    """Without a wall the centre of gravity is the truth."""
    scene = FlashingLight(
        width=120, height=90, background=0.0, texture=0.0, noise=SILENT, sigma=3.0
    )
    camera = MovingCamera(scene, shift_x=4.0, turn=5.0)
    image, truth = camera.frame(2).astype(float), camera.truth(2)
    rows, columns = np.mgrid[:90, :120]
    # Rounding moves the sum of 200 pixels by less than 0.01 px.
    assert (image * columns).sum() / image.sum() == pytest.approx(truth.x, abs=0.01)
    assert (image * rows).sum() / image.sum() == pytest.approx(truth.y, abs=0.01)
    still = scene.truth(2)
    assert np.hypot(truth.x - still.x, truth.y - still.y) > 3.0
    assert camera.frame(1).max() == 0

"""The rendered board against geometry that is known without it."""

from __future__ import annotations

from blob_tracker.simulation.board import BoardPrint, BoardScene, Pose
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import SensorNoise
import numpy as np
import pytest
from support.boards import camera, CHESSBOARD, printed

SQUARE_ON = Pose(np.zeros(3), np.array([-100.0, -62.5, 400.0]))


@pytest.mark.parametrize('distortion_model', ['plumb_bob', 'rational_polynomial', 'equidistant'])
def test_a_disc_of_ink_lies_where_the_truth_says(distortion_model: str) -> None:
    """The centroid of a small square of ink, far out in a distorted image, is its true place."""
    model = camera(np.random.default_rng(1), distortion_model)
    ink = np.full((41, 41), 255, dtype=np.uint8)
    ink[16:25, 16:25] = 0  # 9 mm about (20.5, 20.5), of elements of 1 mm
    scene = BoardScene(BoardPrint(ink, 1.0, 0.0, 0.0), model)
    for place in ((-120.0, -90.0), (0.0, 0.0), (60.0, 80.0)):
        pose = Pose(np.zeros(3), np.array([*place, 300.0]))
        x, y = scene.truth(np.array([[20.5, 20.5]]), pose)[0]
        column, row = int(round(x)), int(round(y))
        window = scene.mean(pose)[row - 14: row + 15, column - 14: column + 15].astype(float)
        signal = scene.white - window
        across = np.arange(-14, 15)
        centroid = np.array([(signal.sum(axis=0) @ across), (signal.sum(axis=1) @ across)])
        centroid /= signal.sum()
        # Distortion draws the outer half smaller than the inner one, by up to 0.05 px here.
        assert centroid + (column, row) == pytest.approx((x, y), abs=0.06)


def test_area_and_levels_are_those_of_the_board() -> None:
    """Without blur, ink and paper have their levels, and as many pixels as the geometry says."""
    model = camera(np.random.default_rng(2))
    ideal = type(model)(640, 480, model.matrix, np.zeros(5))
    scene = BoardScene(printed(CHESSBOARD), ideal, blur=0.0)
    mean = scene.mean(SQUARE_ON)
    assert mean.min() == pytest.approx(scene.black, abs=0.01)
    assert mean.max() == pytest.approx(scene.white, abs=0.01)
    board = (mean != scene.surroundings).sum()
    scale = ideal.matrix[0, 0] * ideal.matrix[1, 1] / 400.0**2
    assert board == pytest.approx(12 * 9 * 25.0**2 * scale, rel=0.02)  # to a pixel of its rim


def test_noise_is_the_sensor_s_and_the_seed_repeats_it() -> None:
    """The same generator state gives the same bits; the scatter is that of the sensor."""
    model = camera(np.random.default_rng(3))
    scene = BoardScene(printed(CHESSBOARD), model, sensor=Sensor(SensorNoise(5.0, 1.0)))
    first = scene.frame(SQUARE_ON, np.random.default_rng(4))
    assert (first == scene.frame(SQUARE_ON, np.random.default_rng(4))).all()
    behind = scene.mean(SQUARE_ON) == scene.surroundings
    expected = np.sqrt(scene.surroundings / 5.0 + 1.0 + 1.0 / 12.0)
    assert first[behind].std() == pytest.approx(expected, rel=0.02)


def test_a_board_out_of_sight_leaves_the_surroundings() -> None:
    """Beside the image, or behind the camera."""
    model = camera(np.random.default_rng(5))
    scene = BoardScene(printed(CHESSBOARD), model)
    for place in ((5000.0, 0.0, 400.0), (0.0, 0.0, -400.0)):
        mean = scene.mean(Pose(np.zeros(3), np.array(place)))
        assert mean == pytest.approx(np.full(mean.shape, scene.surroundings), rel=1e-6)

"""A lens is one file and one line: all that a lens does is had by one that is only registered."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.calibration.board import calibrate_board
from blob_tracker.calibration.boards import View
from blob_tracker.calibration.bundle import project
from blob_tracker.camera import CameraModel, write_calibration
from blob_tracker.camera.lens import LENSES
from blob_tracker.camera.lens.numerical import projection, slopes
from blob_tracker.commands.calibrate.board import add_arguments
from blob_tracker.simulation.board import BoardPrint, BoardScene, Pose
import numpy as np
import pytest
from support.boards import CHESSBOARD, poses, printed
from support.camera_models import EQUIDISTANT, MODELS
from support.sphere_lens import LENS

XI = 0.8


@pytest.fixture(autouse=True)
def camera(monkeypatch: pytest.MonkeyPatch) -> CameraModel:
    """Add the line to the registry; return a camera with the lens."""
    monkeypatch.setitem(LENSES, 'sphere', LENS)
    matrix = np.array([[700.0, 0.0, 322.0], [0.0, 703.0, 238.0], [0.0, 0.0, 1.0]])
    return CameraModel(640, 480, matrix, np.array([XI]), 'sphere')


def test_a_pixel_becomes_a_ray_and_a_pixel_again(camera: CameraModel) -> None:
    """Both ways, to rounding, and with the derivative that the differences have."""
    for x, y in ((0.0, 0.0), (322.0, 238.0), (639.0, 400.0)):
        ray, derivative = camera.unproject(x, y)
        np.testing.assert_allclose(camera.project(ray[None])[0], (x, y), rtol=0, atol=1e-10)
        moved = [
            (camera.unproject(x + a, y + b)[0] - camera.unproject(x - a, y - b)[0]) / 2e-3
            for a, b in ((1e-3, 0.0), (0.0, 1e-3))
        ]
        np.testing.assert_allclose(derivative, np.transpose(moved), rtol=1e-5, atol=1e-9)


def test_its_calibration_file_is_read_back(camera: CameraModel, tmp_path: Path) -> None:
    """The name and the coefficient are in the file."""
    write_calibration(tmp_path / 'sphere.yaml', camera)
    read = CameraModel.from_file(tmp_path / 'sphere.yaml')
    assert (read.distortion_model, read.distortion.tolist()) == ('sphere', [XI])


def test_it_is_offered_for_a_board() -> None:
    """`calibrate board --model` takes it."""
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    arguments = parser.parse_args(
        ['folder', '--kind', 'chessboard', '--columns', '9', '--rows', '6', '--square', '25',
         '--model', 'sphere']
    )
    assert arguments.model == 'sphere'


def test_a_board_tells_it(camera: CameraModel) -> None:
    """From corners with noise, within four sigmas of each parameter."""
    random = np.random.default_rng(31)
    scene = BoardScene(printed(CHESSBOARD), camera)
    points = 25.0 * np.stack(np.meshgrid(np.arange(9.0), np.arange(6.0)), -1).reshape(-1, 2)
    sigma = 0.05
    views = [
        View(points, scene.truth(points, pose) + random.normal(0.0, sigma, points.shape),
             (camera.width, camera.height))
        for pose in poses(random, CHESSBOARD, camera, count=12)
    ]
    found = calibrate_board(views, 'sphere')
    assert found.names == ('fx', 'fy', 'cx', 'cy', 'xi')
    true = [*camera.matrix[[0, 1, 0, 1], [0, 1, 2, 2]], XI]
    assert (np.abs(found.values - true) < 4.0 * found.sigmas).all()
    assert found.sigmas[4] < 0.05  # and it is told
    # 1219 degrees of freedom: the standard error of the scatter is 2 %.
    assert found.sigma == pytest.approx(sigma, rel=0.08)


def test_the_lab_draws_it(camera: CameraModel) -> None:
    """The centroid of a small square of ink is its true place, as with every lens."""
    ink = np.full((41, 41), 255, dtype=np.uint8)
    ink[16:25, 16:25] = 0
    scene = BoardScene(BoardPrint(ink, 1.0, 0.0, 0.0), camera)
    pose = Pose(np.zeros(3), np.array([60.0, 80.0, 300.0]))
    x, y = scene.truth(np.array([[20.5, 20.5]]), pose)[0]
    column, row = int(round(x)), int(round(y))
    window = scene.mean(pose)[row - 14: row + 15, column - 14: column + 15].astype(float)
    signal, across = scene.white - window, np.arange(-14, 15)
    centroid = np.array([signal.sum(axis=0) @ across, signal.sum(axis=1) @ across]) / signal.sum()
    assert centroid + (column, row) == pytest.approx((x, y), abs=0.06)


@pytest.mark.parametrize('model', [MODELS['plumb_bob'], EQUIDISTANT])
def test_differences_are_the_derivatives_of_opencv(model: CameraModel) -> None:
    """Within what a central difference of 1e-6 leaves; slopes to what its iteration does."""
    points = np.array([[0.0, 0.0, 0.0], [120.0, 30.0, 0.0], [-80.0, 90.0, 0.0]])
    rotation, translation = np.array([0.2, -0.4, 0.1]), np.array([10.0, -20.0, 500.0])
    lens, coefficients = LENSES[model.distortion_model], np.asarray(model.distortion, float)
    known = project(points, rotation, translation, model)
    found = projection(lens.image)(points, rotation, translation, model.matrix, coefficients)
    for one, other in zip(found, known):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6 * np.abs(other).max())
    np.testing.assert_allclose(
        slopes(lens.ray)(known.places, model.matrix, coefficients),
        lens.slopes(known.places, model.matrix, coefficients), rtol=0, atol=1e-8,
    )

"""A board's calibration against the camera that the views were made with."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.board import BoardCalibration, calibrate_board
from blob_tracker.calibration.boards import DotGrid, View
from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.simulation.board import BoardScene
from boards import ASYMMETRIC, camera, CHARUCO, CHESSBOARD, DOTS, poses, printed
import numpy as np
import pytest
from scipy.stats import chi2

# Where bearings are compared, as parts of width and height: where the views have points.
PLACES = (0.5, 0.2)
SIGMA = 0.08  # px, of simulated corners: what cv2.cornerSubPix reaches on a grainy image


def corners(
    random: np.random.Generator, model: CameraModel, count: int, **tilts: tuple[float, float]
) -> list[View]:
    """Return views of the chessboard with Gaussian errors, without images."""
    scene = BoardScene(printed(CHESSBOARD), model)
    y, x = np.divmod(np.arange(54), 9)
    points = 25.0 * np.column_stack([x, y]).astype(float)
    return [
        View(
            points,
            scene.truth(points, pose) + random.normal(0.0, SIGMA, points.shape),
            (model.width, model.height),
            f'view {index}',
        )
        for index, pose in enumerate(poses(random, CHESSBOARD, model, count=count, **tilts))
    ]


def rendered(random: np.random.Generator, board, model: CameraModel, count: int) -> list[View]:
    """Return views of a board as found in noisy images of it."""
    scene = BoardScene(printed(board), model)
    views = []
    for pose in poses(random, board, model, count=count):
        view = board.find(scene.frame(pose, random), f'view {len(views)}')
        assert view is not None
        views.append(view)
    return views


def distances(found: BoardCalibration, true: CameraModel) -> list[float]:
    """Return chi-square of fx, fy, cx, cy, and of the bearing at the centre and far from it."""
    error = found.values[:4] - true.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    chi = [float(error @ np.linalg.solve(found.covariance[:4, :4], error))]
    for part in PLACES:
        x, y = part * true.width, part * true.height
        off = np.array(found.model.angles(x, y)[:2]) - true.angles(x, y)[:2]
        chi.append(float(off @ np.linalg.solve(found.bearing_covariance(x, y), off)))
    return chi


def assert_consistent(chi: list[list[float]]) -> None:
    """Hold each chi-square, summed over the draws, within its 95 % bounds."""
    total = np.sum(chi, axis=0)
    for value, freedom in zip(total, (4, 2, 2)):
        low, high = chi2.ppf([0.025, 0.975], freedom * len(chi))
        assert low < value < high


@pytest.mark.parametrize(
    'distortion_model, draws',
    [('plumb_bob', 40), ('rational_polynomial', 15), ('equidistant', 15)],
)
def test_simulated_corners_recover_the_camera(distortion_model: str, draws: int) -> None:
    """Random cameras and poses: the error is as large as the covariance says, no more no less."""
    random = np.random.default_rng(20)
    chi = []
    for _ in range(draws):
        true = camera(random, distortion_model)
        found = calibrate_board(corners(random, true, 8), distortion_model)
        assert not found.left_out
        chi.append(distances(found, true))
    assert_consistent(chi)


def test_rendered_chessboards_recover_the_camera() -> None:
    """Thirty random cameras, from images: with the seventy above, a hundred draws."""
    random = np.random.default_rng(21)
    chi = []
    for _ in range(30):
        true = camera(random, width=320)
        found = calibrate_board(rendered(random, CHESSBOARD, true, 8))
        chi.append(distances(found, true))
    assert_consistent(chi)

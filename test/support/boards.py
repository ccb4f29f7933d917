"""Boards in random poses before random cameras."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.calibration.boards import Board, CharucoBoard, Chessboard, DotGrid
from blob_tracker.camera import CameraModel
from blob_tracker.simulation.board import (
    BoardPrint, BoardScene, charuco_print, chessboard_print, dot_grid_print, Pose,
)
import numpy as np

CHESSBOARD = Chessboard(9, 6, 25.0)
CHARUCO = CharucoBoard(8, 6, 30.0, 22.0)
DOTS = DotGrid(9, 7, 25.0)
ASYMMETRIC = DotGrid(4, 11, 18.0, asymmetric=True)


def printed(board: Board) -> BoardPrint:
    """Return the print of one of the boards above."""
    if board is CHESSBOARD:
        return chessboard_print(9, 6, 25.0)
    if board is CHARUCO:
        return charuco_print(8, 6, 30.0, 22.0, 'DICT_4X4_50')
    assert isinstance(board, DotGrid)
    return dot_grid_print(board.points(), 14.0, 25.0)


def camera(
    random: np.random.Generator, distortion_model: str = 'plumb_bob', width: int = 640
) -> CameraModel:
    """Draw a camera: focal lengths by 5 %, principal point by 2 % of the width, distortion."""
    height = width * 3 // 4
    focal = width * (0.93 if distortion_model != 'equidistant' else 0.5)
    fx, fy = focal * random.normal(1.0, 0.05, 2)
    cx, cy = np.array([width - 1.0, height - 1.0]) / 2 + random.normal(0.0, 0.02 * width, 2)
    radial, tangential = random.normal(0.0, 1.0, 6), random.normal(0.0, 1e-3, 2)
    distortion = {
        'plumb_bob': [-0.25 + 0.05 * radial[0], 0.08 + 0.02 * radial[1], *tangential, 0.0],
        'rational_polynomial': [
            0.4 + 0.05 * radial[0], 0.1, *tangential, 0.01, 0.7 + 0.05 * radial[1], 0.2, 0.02,
        ],
        'equidistant': (radial[:4] * [0.02, 0.01, 0.002, 0.001]).tolist(),
    }[distortion_model]
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return CameraModel(width, height, matrix, np.array(distortion), distortion_model)


def poses(
    random: np.random.Generator,
    board: Board,
    model: CameraModel,
    *,
    count: int,
    tilt: tuple[float, float] = (15.0, 45.0),
) -> Iterator[Pose]:
    """Draw poses, tilted by so many degrees, in which all of the board is in the image."""
    outline = board.outline()
    middle = outline.mean(axis=0)
    width = float(np.ptp(outline[:, 0]))
    scene = BoardScene(printed(CHESSBOARD), model)  # for its projection alone
    size = np.array([model.width, model.height])
    while count:
        angle, direction = np.radians(random.uniform(*tilt)), random.uniform(0.0, 2.0 * np.pi)
        rotation = np.array([np.cos(direction), np.sin(direction), 0.0]) * angle
        rotation[2] = random.uniform(-0.3, 0.3)
        reach = model.matrix[0, 0] / model.width  # of the distance, for the board to fill a part
        depth = width * reach * random.uniform(1.2, 2.2)
        place = depth * np.array([*(random.uniform(-0.4, 0.4, 2) / reach), 1.0])
        still = Pose(rotation, np.zeros(3))
        pose = Pose(rotation, place - still.matrix @ np.array([*middle, 0.0]))
        corners = scene.truth(outline, pose)
        margin = 0.06 * model.width  # for the squares and dots about the outermost points
        if (corners > margin).all() and (corners < size - margin).all():
            count -= 1
            yield pose

"""Each kind of board is found, and its points are where they truly are."""

from __future__ import annotations

from blob_tracker.calibration.boards import Board, BoardError, CharucoBoard, Chessboard, DotGrid
from blob_tracker.calibration.dot_centres import centre_offsets
from blob_tracker.simulation.board import BoardScene
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import SensorNoise
import cv2
import numpy as np
import pytest
from support.boards import ASYMMETRIC, camera, CHARUCO, CHESSBOARD, DOTS, poses, printed

# rms of a coordinate, px, at a contrast of 160 DN and a noise of 2 DN: measured 0.006, 0.007,
# 0.009, 0.009; what was asked for is 0.05.
LIMITS = {'chessboard': 0.01, 'charuco': 0.012, 'dots': 0.015, 'asymmetric': 0.015}
BOARDS: dict[str, Board] = {
    'chessboard': CHESSBOARD, 'charuco': CHARUCO, 'dots': DOTS, 'asymmetric': ASYMMETRIC,
}


@pytest.mark.parametrize('saturation', [255, 4095])
@pytest.mark.parametrize('kind', BOARDS)
def test_points_are_where_they_truly_are(kind: str, saturation: int) -> None:
    """On 8 and 16 bits, through a distorting lens; dots once their centres' offset is taken."""
    random = np.random.default_rng(40)
    board, model, scale = BOARDS[kind], camera(np.random.default_rng(41)), saturation / 255
    scene = BoardScene(
        printed(board), model, 30.0 * scale, 190.0 * scale, 90.0 * scale,
        sensor=Sensor(SensorNoise(40.0 / scale, 0.7 * scale), saturation.bit_length()),
    )
    errors = []
    for pose in poses(random, board, model, count=6):
        view = board.find(scene.frame(pose, random))
        assert view is not None
        # A board that can be turned round without a difference may be found turned round.
        turned = board.outline().sum(axis=0) / 2 - view.points
        offsets = []
        for points in (view.points, turned):
            places = scene.truth(points, pose)
            if view.diameter:
                places = places + centre_offsets(
                    points, view.diameter, pose.rotation, pose.translation, model
                )
            offsets.append(view.places - places)
        errors.append(min(offsets, key=lambda each: float(np.abs(each).sum())))
    assert np.sqrt(np.mean(np.vstack(errors) ** 2)) < LIMITS[kind]
    assert np.abs(np.vstack(errors)).max() < 0.1


def test_corners_are_nearer_than_those_of_corner_sub_pix() -> None:
    """The fit of the picture of a corner is why this is not left to OpenCV."""
    random = np.random.default_rng(42)
    model = camera(random)
    scene = BoardScene(printed(CHESSBOARD), model)
    ours, theirs = [], []
    for pose in poses(random, CHESSBOARD, model, count=5):
        image = scene.frame(pose, random)
        view = CHESSBOARD.find(image)
        assert view is not None
        start = np.ascontiguousarray(view.places[:, None], dtype=np.float32)
        criteria = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, 50, 1e-4)
        other = cv2.cornerSubPix(image, start, (5, 5), (-1, -1), criteria)[:, 0]
        truth = min(
            (scene.truth(points, pose) for points in (view.points, view.points[::-1])),
            key=lambda each: float(np.abs(view.places - each).sum()),
        )
        ours.append(view.places - truth)
        theirs.append(other - truth)
    assert np.std(np.vstack(ours)) < 0.5 * np.std(np.vstack(theirs))  # measured 0.2


@pytest.mark.parametrize('kind', BOARDS)
def test_no_board_is_none(kind: str) -> None:
    """Noise, an even image, and another board hold none."""
    random = np.random.default_rng(43)
    model = camera(random)
    other = DOTS if kind in ('chessboard', 'charuco') else CHESSBOARD
    pose = next(poses(random, other, model, count=1))
    picture = BoardScene(printed(other), model).frame(pose, random)
    noise = random.integers(0, 255, (240, 320), dtype=np.uint8)
    for image in (picture, noise, np.full((240, 320), 90, dtype=np.uint8)):
        assert BOARDS[kind].find(image) is None


def test_a_part_of_a_charuco_board_is_enough() -> None:
    """The corners that are in sight keep their places on the board."""
    random = np.random.default_rng(44)
    model = camera(random)
    scene = BoardScene(printed(CHARUCO), model)
    pose = next(poses(random, CHARUCO, model, count=1))
    image = scene.frame(pose, random)
    half = int(scene.truth(CHARUCO.outline(), pose)[:, 0].mean())
    image[:, half:] = 90
    view = CHARUCO.find(image)
    assert view is not None
    assert 6 <= len(view.points) < 30
    assert np.abs(view.places - scene.truth(view.points, pose)).max() < 0.1


@pytest.mark.parametrize(
    'make, sentence',
    [
        (lambda: Chessboard(2, 6, 25.0), 'it must be 3 x 3 or more'),
        (lambda: DotGrid(4, 11, 0.0), 'must be above 0'),
        (lambda: CharucoBoard(8, 6, 30.0, 30.0), 'below the square, 30.0 mm'),
        (lambda: CharucoBoard(8, 6, 30.0, 22.0, 'DICT_3X3'), 'there is DICT_'),
        (lambda: CharucoBoard(20, 20, 30.0, 22.0), 'DICT_4X4_50 has 50 markers'),
    ],
)
def test_impossible_boards_are_refused(make, sentence: str) -> None:
    """One sentence that says what would be right."""
    with pytest.raises(BoardError, match=sentence):
        make()

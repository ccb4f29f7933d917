"""What the views leave open, said before anybody uses the calibration."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.board import calibrate_board
from blob_tracker.calibration.board_advice import advice
from blob_tracker.calibration.boards import View
from blob_tracker.simulation.board import BoardScene, Pose
import numpy as np
from support.boards import camera, CHESSBOARD, poses, printed

POINTS = 25.0 * np.column_stack(np.divmod(np.arange(54), 9)[::-1]).astype(float)


def views(
    count: int, tilt: tuple[float, float], around: np.ndarray | None = None
) -> list[View]:
    """Return views tilted by so many degrees, about one axis where it is given."""
    random = np.random.default_rng(30)
    model = camera(random)
    scene = BoardScene(printed(CHESSBOARD), model)
    seen: list[View] = []
    for pose in poses(random, CHESSBOARD, model, count=count, tilt=tilt):
        if around is not None:
            turn = around * np.radians(random.uniform(*tilt))
            middle = np.array([100.0, 62.5, 0.0])
            place = pose.matrix @ middle + pose.translation
            pose = Pose(turn, place - Pose(turn, place).matrix @ middle)
        places = scene.truth(POINTS, pose) + random.normal(0.0, 0.01, (54, 2))
        seen.append(View(POINTS, places, (640, 480), f'view {len(seen)}'))
    return seen


def test_good_views_need_nothing() -> None:
    """Forty views all over the image, tilted all ways."""
    assert advice(calibrate_board(views(40, (15.0, 40.0)))) == []


def test_square_views_are_told_of() -> None:
    """Nobody tilted the board."""
    words = ' '.join(advice(calibrate_board(views(12, (1.0, 4.0)))))
    assert 'all views face the camera squarely' in words
    assert 'tilt the board by 30 degrees' in words


def test_a_missing_tilt_is_named() -> None:
    """The board was turned about the upright axis alone."""
    words = ' '.join(advice(calibrate_board(views(12, (20.0, 35.0), np.array([0.0, 1.0, 0.0])))))
    assert 'tilted up or down' in words
    assert 'tilted left or right' not in words


def test_few_views_are_told_of() -> None:
    """Five do for a fit and little else."""
    assert '5 views are few' in advice(calibrate_board(views(5, (15.0, 40.0))))[0]


def test_empty_fields_are_named() -> None:
    """The board was never in the lower right quarter."""
    taken = [
        replace(view, points=view.points[keep], places=view.places[keep])
        for view in views(40, (15.0, 40.0))
        for keep in [(view.places[:, 0] < 470.0) | (view.places[:, 1] < 350.0)]
        if keep.sum() > 20
    ]
    words = advice(calibrate_board(taken))
    assert words == [
        'no point of the board lies in the bottom right of the image: take a picture with the '
        'board there'
    ]

"""Points that lie as a board's do, and points that do not."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.boards import Chessboard, DotGrid, View
from blob_tracker.calibration.boards.board import grid
from blob_tracker.calibration.boards.regularity import is_even, roughness
from blob_tracker.simulation.board import BoardScene
import numpy as np
import pytest
from support.boards import camera, CHESSBOARD, poses, printed


@pytest.mark.parametrize('model', ['plumb_bob', 'equidistant'])
@pytest.mark.parametrize('board', [CHESSBOARD, DotGrid(4, 11, 18.0, asymmetric=True)])
def test_a_board_in_perspective_is_even(board: Chessboard | DotGrid, model: str) -> None:
    """However it is tilted, and through a fish-eye."""
    random = np.random.default_rng(3)
    lens = camera(random, model)
    points = board.points() if isinstance(board, DotGrid) else grid(9, 6, 25.0)
    for pose in poses(random, board, lens, count=20):
        places = BoardScene(printed(CHESSBOARD), lens).truth(points, pose)
        assert is_even(View(points, places, (640, 480)))


def test_a_wide_pinhole_close_to_the_board_is_even() -> None:
    """Tilted by 65 degrees before 131 degrees of view, its squares shrink from 163 to 9 px."""
    points = grid(9, 6, 25.0)
    cosine, sine = np.cos(np.radians(65.0)), np.sin(np.radians(65.0))
    x, y = (points - points.mean(axis=0)).T
    depth = 130.0 + sine * x
    places = 290.0 * np.column_stack([cosine * x, y]) / depth[:, None] + [640.0, 480.0]
    assert ((places > 0.0) & (places < [1280.0, 960.0])).all()
    places += np.random.default_rng(5).normal(0.0, 0.05, places.shape)
    assert is_even(View(points, places, (1280, 960)))


def test_a_row_that_was_passed_over_is_uneven() -> None:
    """What the detectors make of 9 x 6 corners where 9 x 5 were asked for."""
    whole = 40.0 * grid(9, 6, 1.0)
    kept = np.delete(np.arange(54).reshape(6, 9), 2, axis=0).ravel()
    view = View(grid(9, 5, 25.0), whole[kept], (640, 480))
    assert not is_even(view)
    assert is_even(replace(view, places=40.0 * grid(9, 5, 1.0)))


def test_points_without_neighbours_are_not_judged() -> None:
    """Six corners of a ChArUco board, no three of them in a row."""
    points = np.array([[0, 0], [1, 0], [4, 0], [5, 1], [0, 3], [3, 4]], dtype=float)
    assert is_even(View(points, 9.0 * points**2, (640, 480)))


def test_roughness_is_the_error_of_the_points() -> None:
    """Through a lens and tilted: what bends slowly does not count."""
    random = np.random.default_rng(4)
    lens = camera(random)
    points = grid(9, 6, 25.0)
    errors = []
    for pose in poses(random, CHESSBOARD, lens, count=30):
        places = BoardScene(printed(CHESSBOARD), lens).truth(points, pose)
        shaken = places + random.normal(0.0, 0.1, places.shape)
        bend, both = (roughness(each.reshape(6, 9, 2)) for each in (places, shaken))
        assert bend < 0.2  # px: what perspective and distortion add, in squares
        errors.append(both**2 - bend**2)
    # 30 views of 126 correlated differences each: 3 % of the root.
    assert np.sqrt(np.mean(errors)) == pytest.approx(0.1, rel=0.09)

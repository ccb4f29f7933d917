"""Which views of a stream are kept."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.board_views import BoardViews
from blob_tracker.calibration.boards import View
from blob_tracker.simulation.board import BoardScene
import numpy as np
from support.boards import camera, CHESSBOARD, poses, printed

POINTS = 25.0 * np.column_stack(np.divmod(np.arange(54), 9)[::-1]).astype(float)


def view(seed: int, *, shift: float = 0.0) -> View:
    """Return a view in a pose of its own, shifted by so many pixels."""
    random = np.random.default_rng(seed)
    model = camera(np.random.default_rng(1))
    pose = next(poses(random, CHESSBOARD, model, count=1))
    places = BoardScene(printed(CHESSBOARD), model).truth(POINTS, pose)
    return View(POINTS, places + shift, (640, 480), f'{seed} {shift:g}')


def test_only_what_differs_is_kept() -> None:
    """The same pose counts once, whichever way round the board is seen; another pose is new."""
    chosen = BoardViews(CHESSBOARD)
    assert chosen.offer(view(1))
    chosen.offer(view(1))
    chosen.offer(view(1, shift=3.0))
    turned = replace(view(1), points=POINTS[::-1])
    chosen.offer(turned)
    assert len(chosen.views) == 1
    assert chosen.offer(view(2))
    assert len(chosen.views) == 2


def test_the_steadiest_of_like_views_is_kept() -> None:
    """The board comes in moving, rests, and moves on: the view at rest stays."""
    chosen = BoardViews(CHESSBOARD)
    for shift in (-12.0, -4.0, -0.5, 0.0, 5.0, 12.0):
        chosen.offer(view(1, shift=shift))
    assert [each.name for each in chosen.views] == ['1 0']


def test_images_without_a_board_change_nothing() -> None:
    """And the view after them has no view before it to have moved from."""
    chosen = BoardViews(CHESSBOARD)
    chosen.offer(view(1))
    assert not chosen.offer(None)
    assert not chosen.offer(view(1))
    assert len(chosen.views) == 1

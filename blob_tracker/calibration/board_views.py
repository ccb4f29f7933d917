"""Of a stream of images, the views of a board that differ enough to tell something new."""

from __future__ import annotations

from blob_tracker.calibration.boards import Board, View
import cv2
import numpy as np
from numpy.typing import NDArray

NEW = 0.05  # of the image's diagonal: how far the board's corners must have moved

Array = NDArray[np.float64]


class BoardViews:
    """
    Choose views as they come.

    A view is kept where the board's four corners lie 5 % of the image's diagonal, in the mean,
    away from where they lie in any other. Of those that lie nearer, the one is kept in which the
    board moved least since the image before: a moving board is blurred, and bent by a rolling
    shutter.

    Parameters
    ----------
    board : Board
        What is looked for.

    """

    def __init__(self, board: Board) -> None:
        self._outline = board.outline()
        self._kept: list[tuple[View, Array, float]] = []  # view, outline in px, moved, px
        self._last: Array | None = None

    @property
    def views(self) -> list[View]:
        """Those that were kept."""
        return [view for view, _, _ in self._kept]

    def offer(self, view: View | None) -> bool:
        """
        Take the next image into account.

        Parameters
        ----------
        view : View or None
            What is seen of the board in it, None if nothing is.

        Returns
        -------
        bool
            Whether the views are others now.

        """
        outline = None if view is None else self._seen(view)
        before, self._last = self._last, outline
        if view is None or outline is None:
            return False
        moved = np.inf if before is None else _distance(outline, before)
        new = NEW * float(np.hypot(*view.size))
        near = [
            index for index, (_, other, _) in enumerate(self._kept)
            if _distance(outline, other) < new
        ]
        if not near:
            self._kept.append((view, outline, moved))
            return True
        if len(near) == 1 and moved < self._kept[near[0]][2]:
            self._kept[near[0]] = (view, outline, moved)
            return True
        return False

    def _seen(self, view: View) -> Array | None:
        """Return where the board's corners lie in the image, or would, (4, 2), px."""
        onto, _ = cv2.findHomography(view.points, view.places)
        if onto is None:
            return None
        return np.asarray(cv2.perspectiveTransform(self._outline[:, None], onto)[:, 0])


def _distance(outline: Array, other: Array) -> float:
    """Return the mean distance of two outlines, px; a board that was turned round is the same."""
    return min(
        float(np.linalg.norm(outline - turned, axis=1).mean())
        for turned in (other, np.roll(other, 2, axis=0))
    )

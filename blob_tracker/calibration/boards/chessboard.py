"""Chessboard: black and white squares, all of which must be in the image."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.calibration.boards.board import check_grid, eight_bits, grid, rectangle, View
from blob_tracker.calibration.boards.regularity import roughness
from blob_tracker.calibration.boards.saddle import place_saddles
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

OLDER = (
    cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
)
THOROUGH = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE
RADIUS = 0.3  # of the distance to the next corner: what the fit looks at


@dataclass(frozen=True)
class Chessboard:
    """
    A chessboard, found by OpenCV, its corners placed by `place_saddles`.

    Where a picture is aliased or its squares have few pixels, those of OpenCV's sector detector
    (Duda & Frese, BMVC 2018) may lie more evenly, and are taken.

    Parameters
    ----------
    columns, rows : int
        Inner corners, where four squares meet; one less than the squares.
    square : float
        Side of a square, mm.

    Raises
    ------
    BoardError
        If the board is invalid.

    """

    columns: int
    rows: int
    square: float

    def __post_init__(self) -> None:
        check_grid(self.columns, self.rows, self.square, least=3)

    @property
    def description(self) -> str:
        """Return what is looked for, for a sentence."""
        return f'chessboard of {self.columns} x {self.rows} inner corners'

    def outline(self) -> NDArray[np.float64]:
        """Return the four outermost corners, (4, 2), mm."""
        return rectangle(self._points())

    def find(self, image: Pixels, name: str = '') -> View | None:
        """Find all corners, or none; see `Board.find`."""
        size = (self.columns, self.rows)
        greys = eight_bits(image)
        found, corners = cv2.findChessboardCornersSB(greys, size)
        precise = found
        if not found:  # of small squares it misses one board in a hundred, which the older finds
            found, corners = cv2.findChessboardCorners(greys, size, flags=OLDER)
        if not found:  # slower
            found, corners = cv2.findChessboardCornersSB(greys, size, flags=THOROUGH)
        if not found:
            return None
        places = np.asarray(corners, dtype=float).reshape(self.rows, self.columns, 2)
        along, down = np.gradient(places, axis=1), np.gradient(places, axis=0)
        edges = np.stack([np.arctan2(step[..., 1], step[..., 0]) for step in (along, down)], -1)
        nearest = min(np.hypot(step[..., 0], step[..., 1]).min() for step in (along, down))
        saddles, placed = place_saddles(
            image, places.reshape(-1, 2), edges.reshape(-1, 2), RADIUS * nearest
        )
        if precise and max(size) > 3 and roughness(places) < roughness(
            saddles.reshape(places.shape)
        ):
            saddles, placed = places.reshape(-1, 2), np.ones(len(saddles), dtype=bool)
        if not placed.any():
            return None
        height, width = image.shape
        return View(self._points()[placed], saddles[placed], (width, height), name)

    def _points(self) -> NDArray[np.float64]:
        return grid(self.columns, self.rows, self.square)

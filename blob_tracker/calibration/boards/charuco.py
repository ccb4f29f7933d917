"""ChArUco: a chessboard with markers in its white squares, of which a part is enough."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from blob_tracker.calibration.boards.board import (
    BoardError, check_grid, eight_bits, grid, rectangle, View,
)
from blob_tracker.calibration.boards.saddle import place_saddles
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

LEAST_CORNERS = 6  # fewer in an image tell its pose and little else
# Of the way from a corner to the nearest corner of a marker: what the fit looks at.
RADIUS = 0.85


@dataclass(frozen=True)
class CharucoBoard:
    """
    A ChArUco board, found by cv2.aruco, its corners placed by `place_saddles`.

    Parameters
    ----------
    columns, rows : int
        Squares.
    square, marker : float
        Side of a square and of a marker, mm.
    dictionary : str
        OpenCV's name of the markers: DICT_4X4_50.

    Raises
    ------
    BoardError
        If the board is invalid.

    """

    columns: int
    rows: int
    square: float
    marker: float
    dictionary: str = 'DICT_4X4_50'

    def __post_init__(self) -> None:
        check_grid(self.columns, self.rows, self.square, least=3)
        if not 0.0 < self.marker < self.square:
            raise BoardError(
                f'the marker is {self.marker} mm; it must be above 0 and below the square, '
                f'{self.square} mm'
            )
        names = [name for name in dir(cv2.aruco) if name.startswith('DICT_')]
        if self.dictionary not in names:
            raise BoardError(f"no dictionary '{self.dictionary}'; there is {', '.join(names)}")
        held, needed = len(self._markers().bytesList), self.columns * self.rows // 2
        if held < needed:
            raise BoardError(
                f'{self.dictionary} has {held} markers; {self.columns} x {self.rows} squares '
                f'need {needed}'
            )

    @property
    def description(self) -> str:
        """Return what is looked for, for a sentence."""
        return (
            f'ChArUco board of {self.columns} x {self.rows} squares with markers of '
            f'{self.dictionary}'
        )

    def outline(self) -> NDArray[np.float64]:
        """Return the four outermost corners, (4, 2), mm."""
        return rectangle(self._points())

    def find(self, image: Pixels, name: str = '') -> View | None:
        """Find what is in sight of the board, six corners or more; see `Board.find`."""
        corners, identities = self._detect(eight_bits(image))
        if len(identities) < LEAST_CORNERS:
            return None
        points = self._points()[identities]
        onto, _ = cv2.findHomography(points, corners)
        if onto is None:
            return None
        steps = [
            cv2.perspectiveTransform((points + step)[:, None], onto)[:, 0]
            - cv2.perspectiveTransform(points[:, None], onto)[:, 0]
            for step in (np.array([1.0, 0.0]), np.array([0.0, 1.0]))
        ]
        edges = np.stack([np.arctan2(step[:, 1], step[:, 0]) for step in steps], axis=-1)
        margin = np.sqrt(0.5) * (self.square - self.marker)  # to the marker's corner, mm
        radius = RADIUS * margin * min(np.hypot(*step.T).min() for step in steps)
        places, placed = place_saddles(image, corners, edges, radius)
        if placed.sum() < LEAST_CORNERS:
            return None
        height, width = image.shape
        return View(points[placed], places[placed], (width, height), name)

    def _points(self) -> NDArray[np.float64]:
        """Return the (N, 2) inner corners in the order of their identities, mm."""
        return grid(self.columns - 1, self.rows - 1, self.square) + self.square

    def _markers(self) -> cv2.aruco.Dictionary:
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))

    def _detect(
        self, image: NDArray[np.uint8]
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Return the corners (N, 2), px, to about a pixel, and their identities (N,)."""
        size, markers = (self.columns, self.rows), self._markers()
        aruco: Any = cv2.aruco  # its two interfaces
        if not hasattr(aruco, 'CharucoDetector'):  # OpenCV before 4.7: Ubuntu 24.04
            board = aruco.CharucoBoard_create(*size, self.square, self.marker, markers)
            seen, names, _ = aruco.detectMarkers(image, markers)
            corners = identities = None
            if len(seen):
                _, corners, identities = aruco.interpolateCornersCharuco(
                    seen, names, image, board
                )
            return _as_arrays(corners, identities)
        board = aruco.CharucoBoard(size, self.square, self.marker, markers)
        corners, identities, seen, _ = aruco.CharucoDetector(board).detectBoard(image)
        if identities is None and len(seen):  # as OpenCV printed even rows before 4.6
            board.setLegacyPattern(True)
            corners, identities, _, _ = aruco.CharucoDetector(board).detectBoard(image)
        return _as_arrays(corners, identities)


def _as_arrays(
    corners: NDArray[np.float32] | None, identities: NDArray[np.int32] | None
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return what OpenCV gives, None if it is nothing, as arrays."""
    if corners is None or identities is None:
        return np.empty((0, 2)), np.empty(0, dtype=np.intp)
    return np.asarray(corners, dtype=float).reshape(-1, 2), np.ravel(identities).astype(np.intp)

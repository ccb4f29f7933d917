"""What every board can do, and what is seen of it in one image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

GREYS = (1.0, 99.5)  # percentiles that become black and white where 16 bits are looked at with 8


class BoardError(ValueError):
    """A board that cannot be; the message says why."""


@dataclass(frozen=True)
class View:
    """
    The points of a board in one image.

    Parameters
    ----------
    points : (N, 2) array
        Places on the board, mm; its plane is Z = 0.
    places : (N, 2) array
        Where they are in the image, px; (0, 0) is the centre of the top-left pixel.
    size : (int, int)
        Width and height of the image, px.
    name : str
        What to call the image by.
    diameter : float
        Of the dots, as measured, mm; 0 where the points are corners.

    """

    points: NDArray[np.float64]
    places: NDArray[np.float64]
    size: tuple[int, int]
    name: str = ''
    diameter: float = 0.0


class Board(Protocol):
    """A kind of board, of one size."""

    @property
    def description(self) -> str:
        """Return what is looked for, for a sentence: 'chessboard of 9 x 6 inner corners'."""

    def outline(self) -> NDArray[np.float64]:
        """Return the corners of the rectangle about the points, in turn, (4, 2), mm."""

    def find(self, image: Pixels, name: str = '') -> View | None:
        """
        Find the board.

        Parameters
        ----------
        image : (h, w) uint8 or uint16 array
            Raw DN.
        name : str
            What to call the image by.

        Returns
        -------
        View or None
            Its points to a hundredth of a pixel or so; None if it is not there.

        """


def eight_bits(image: Pixels) -> NDArray[np.uint8]:
    """Return an image of 16 bits with 8, as OpenCV's detectors ask for; the others as they are."""
    if image.dtype == np.uint8:
        return np.asarray(image, dtype=np.uint8)
    black, white = np.percentile(image, GREYS)
    scaled = (image - black) * (255.0 / max(white - black, 1.0))
    return np.clip(scaled, 0, 255).astype(np.uint8)


def check_grid(columns: int, rows: int, spacing: float, least: int) -> None:
    """Refuse a grid that is too small, or has no spacing."""
    if min(columns, rows) < least:
        raise BoardError(f'the board is {columns} x {rows}; it must be {least} x {least} or more')
    if not spacing > 0.0:
        raise BoardError(f'the distance on the board is {spacing} mm; it must be above 0')


def grid(columns: int, rows: int, spacing: float) -> NDArray[np.float64]:
    """Return the (N, 2) points of a square grid, mm, row by row, the first at (0, 0)."""
    y, x = np.divmod(np.arange(columns * rows), columns)
    return spacing * np.column_stack([x, y]).astype(float)


def rectangle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of the rectangle about (N, 2) points, in turn, (4, 2)."""
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

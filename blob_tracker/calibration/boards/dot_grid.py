"""Grid of round dots, symmetric or asymmetric, all of which must be in the image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from blob_tracker.calibration.boards.board import check_grid, eight_bits, grid, rectangle, View
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

LEAST_AREA = 12.0  # px^2 of a dot
SKIRT = 2.5  # px about a dot over which a lens spreads its edge
PASSES = 2  # of the placing: the second starts from what the first found

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DotGrid:
    """
    Dark dots on a bright board or bright ones on a dark board, found by cv2.findCirclesGrid.

    Each is placed by the centroid of its own signal. The centroid of a disc's picture is not the
    picture of its centre: `centre_offsets` says by how much, once the camera is known.

    Parameters
    ----------
    columns, rows : int
        Dots; of the asymmetric grid as OpenCV counts them, 4 x 11 say.
    spacing : float
        Distance of the centres of neighbouring dots, mm; of the asymmetric grid that of
        neighbouring rows.
    asymmetric : bool
        Every other row is shifted by half the distance of its dots.

    Raises
    ------
    BoardError
        If the board is invalid.

    """

    columns: int
    rows: int
    spacing: float
    asymmetric: bool = False

    def __post_init__(self) -> None:
        check_grid(self.columns, self.rows, self.spacing, least=3)

    @property
    def description(self) -> str:
        """Return what is looked for, for a sentence."""
        kind = 'asymmetric' if self.asymmetric else 'symmetric'
        return f'{kind} grid of {self.columns} x {self.rows} dots'

    def points(self) -> Array:
        """Return the centres of the dots, (N, 2), mm."""
        if not self.asymmetric:
            return grid(self.columns, self.rows, self.spacing)
        points = grid(self.columns, self.rows, 1.0)
        points[:, 0] = 2.0 * points[:, 0] + points[:, 1] % 2
        return self.spacing * points

    def outline(self) -> Array:
        """Return the corners of the rectangle about the centres, (4, 2), mm."""
        return rectangle(self.points())

    def find(self, image: Pixels, name: str = '') -> View | None:
        """Find all dots, or none; see `Board.find`."""
        greys = eight_bits(image)
        for picture in (greys, np.bitwise_not(greys)):
            centres = self._grid(picture)
            if centres is None:
                continue
            placed = self._place(image, centres)
            if placed is None:
                return None
            height, width = image.shape
            return View(self.points(), placed[0], (width, height), name, placed[1])
        return None

    def _grid(self, image: NDArray[np.uint8]) -> Array | None:
        """Return the centres of dark dots to about a pixel, (N, 2), in the order of `points`."""
        opencv: Any = cv2  # whose types leave the blob detector out
        settings = opencv.SimpleBlobDetector_Params()
        settings.minArea = LEAST_AREA
        settings.maxArea = image.size / (self.columns * self.rows)
        settings.minDistBetweenBlobs = 4.0
        settings.minRepeatability = 2
        kind = cv2.CALIB_CB_ASYMMETRIC_GRID if self.asymmetric else cv2.CALIB_CB_SYMMETRIC_GRID
        for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
            found, centres = cv2.findCirclesGrid(
                image,
                (self.columns, self.rows),
                flags=flags,
                blobDetector=opencv.SimpleBlobDetector_create(settings),
            )
            if found:
                return np.asarray(centres, dtype=float).reshape(-1, 2)
        return None

    def _place(self, image: Pixels, centres: Array) -> tuple[Array, float] | None:
        """Return the centroids of the dots, px, and their diameter, mm; None if not all are."""
        points = self.points()
        reach = 0.5 * self.spacing * (np.sqrt(2.0) if self.asymmetric else 1.0)
        areas = np.empty(len(points))
        for _ in range(PASSES):
            homography, _ = cv2.findHomography(points, centres)
            if homography is None:
                return None
            onto = np.asarray(homography, dtype=np.float64)
            back = np.asarray(np.linalg.inv(onto), dtype=np.float64)
            placed = centres.copy()
            for index, (point, centre) in enumerate(zip(points, centres)):
                found = _centroid(image, point, centre, onto, back, reach)
                if found is None:
                    return None
                placed[index], areas[index] = found
            centres = placed
        return centres, float(np.sqrt(np.median(areas) * 4.0 / np.pi))


def _centroid(
    image: Pixels, point: Array, centre: Array, onto: Array, back: Array, reach: float
) -> tuple[Array, float] | None:
    """
    Place one dot by the centroid of its signal above the board about it.

    Parameters
    ----------
    image : (h, w) array
        DN.
    point, centre : (2,) array
        Of the dot: mm on the board, px in the image.
    onto, back : (3, 3) array
        Homography from mm to px, and from px to mm.
    reach : float
        Half the way to the next dot, mm.

    Returns
    -------
    (2,) array, float or None
        px, and the area of the dot, mm^2; None if it has no contrast or touches the border.

    """
    about = point + reach * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    outline = cv2.perspectiveTransform(about[:, None], onto)[:, 0]
    low = np.maximum(np.floor(outline.min(axis=0)), 0).astype(int)
    high = np.minimum(np.ceil(outline.max(axis=0)) + 1, image.shape[::-1]).astype(int)
    y, x = (side.ravel() for side in np.mgrid[low[1]: high[1], low[0]: high[0]])
    pixels = image[low[1]: high[1], low[0]: high[0]].ravel().astype(float)
    scale = back[2, 0] * x + back[2, 1] * y + back[2, 2]
    middle = cv2.perspectiveTransform(centre[None, None], back)[0, 0]
    away = np.hypot(
        (back[0, 0] * x + back[0, 1] * y + back[0, 2]) / scale - middle[0],
        (back[1, 0] * x + back[1, 1] * y + back[1, 2]) / scale - middle[1],
    )
    near = np.abs(np.linalg.det(back) / scale**3)  # mm^2 to a pixel
    board, dot = pixels[(away > 0.9 * reach) & (away < reach)], pixels[away < 0.2 * reach]
    if not len(board) or not len(dot) or np.median(board) == np.median(dot):
        return None
    contrast = np.median(dot) - np.median(board)
    half = (away < reach) & ((pixels - np.median(board)) / contrast > 0.5)
    radius = np.sqrt(near[half].sum() / np.pi)
    # A pixel is at most so many mm long on the board, along the direction in which it leans.
    local = _derivative(back, centre)
    skirt = SKIRT * np.linalg.norm(local, 2)
    inside = away < min(radius + skirt, 0.9 * reach)
    outside = (away < reach) & ~inside
    if inside.sum() < LEAST_AREA or outside.sum() < LEAST_AREA:
        return None
    plane = np.column_stack([np.ones(len(x)), x - centre[0], y - centre[1]])
    level = np.linalg.lstsq(plane[outside], pixels[outside], rcond=None)[0]
    signal = ((pixels - plane @ level) / contrast)[inside]
    if signal.sum() <= 0.0:
        return None
    weights = signal / signal.sum()
    place = np.array([weights @ x[inside], weights @ y[inside]])
    return place, float((signal * near[inside]).sum())


def _derivative(homography: Array, place: Array) -> Array:
    """Return the derivative of a homography at a place, (2, 2)."""
    image = homography @ np.array([*place, 1.0])
    return (homography[:2, :2] - np.outer(image[:2] / image[2], homography[2, :2])) / image[2]

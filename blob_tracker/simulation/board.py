"""A calibration board in front of a camera: its picture, and where its points truly are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from blob_tracker.camera import CameraModel
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

CLOSE_ENOUGH = 1e-9  # of the normalised coordinates: no picture shows it
KNOTS_PX = 4  # px between the rays that are computed
RIM_SIGMA = 4.0  # sigmas of the blur that reach across the board's edge
# Elements of the print to the side of a square, and to the diameter of a dot. Between elements the
# picture is interpolated: about as fine as the rays, they leave no steps in slanting edges.
FINENESS = 120


@dataclass(frozen=True)
class Pose:
    """
    Where the board is: a point p of it lies at R p + t in the camera's optical frame.

    Parameters
    ----------
    rotation : (3,) array
        Rotation vector of R, rad.
    translation : (3,) array
        t, mm.

    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    @property
    def matrix(self) -> NDArray[np.float64]:
        """R, (3, 3)."""
        return np.asarray(cv2.Rodrigues(np.asarray(self.rotation, dtype=float))[0])


@dataclass(frozen=True)
class BoardPrint:
    """
    What is printed on a board, as elements of equal brightness.

    Parameters
    ----------
    reflectance : (h, w) uint8 array
        255 is white.
    element : float
        Side of an element, mm.
    left, top : float
        Place of the print's upper left edge on the board, mm; x to the right, y down.

    """

    reflectance: NDArray[np.uint8]
    element: float
    left: float
    top: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, mm."""
        height, width = self.reflectance.shape
        return width * self.element, height * self.element


def chessboard_print(columns: int, rows: int, square: float) -> BoardPrint:
    """
    Print a chessboard of so many inner corners, with a white margin of one square.

    The first inner corner is the board's origin.
    """
    y, x = np.indices((rows + 3, columns + 3))
    inside = (x > 0) & (x < columns + 2) & (y > 0) & (y < rows + 2)
    squares = np.where(inside & ((x + y) % 2 == 0), 0, 255).astype(np.uint8)
    picture = np.kron(squares, np.ones((FINENESS, FINENESS), dtype=np.uint8))
    return BoardPrint(picture, square / FINENESS, -2.0 * square, -2.0 * square)


def charuco_print(
    columns: int, rows: int, square: float, marker: float, dictionary: str
) -> BoardPrint:
    """
    Print a ChArUco board of so many squares, with a white margin of half a square.

    The outer corner of the first square is the board's origin, as it is OpenCV's.
    """
    aruco: Any = cv2.aruco  # its two interfaces
    known = aruco.getPredefinedDictionary(getattr(aruco, dictionary))
    size = (columns * FINENESS, rows * FINENESS)
    if hasattr(aruco, 'CharucoDetector'):
        board = aruco.CharucoBoard((columns, rows), square, marker, known)
        picture = board.generateImage(size, marginSize=0)
    else:  # OpenCV before 4.7
        board = aruco.CharucoBoard_create(columns, rows, square, marker, known)
        picture = board.draw(size, marginSize=0)
    margin = FINENESS // 2
    picture = cv2.copyMakeBorder(
        picture, margin, margin, margin, margin, cv2.BORDER_CONSTANT, value=255
    )
    return BoardPrint(np.asarray(picture), square / FINENESS, -0.5 * square, -0.5 * square)


def dot_grid_print(
    points: NDArray[np.float64], diameter: float, margin: float
) -> BoardPrint:
    """Print black discs about these (N, 2) points of a board, mm."""
    element = diameter / FINENESS
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    shape = np.rint((high - low)[::-1] / element).astype(int)
    picture = np.full(shape, 255, dtype=np.uint8)
    reach = FINENESS // 2 + 2
    for point in points:
        centre = (point - low) / element - 0.5
        x, y = np.rint(centre).astype(int)
        block = np.s_[y - reach: y + reach + 1, x - reach: x + reach + 1]
        across = np.arange(-reach, reach + 1)
        away = np.hypot(across + x - centre[0], (across + y - centre[1])[:, None])
        picture[block][away <= 0.5 * FINENESS] = 0
    return BoardPrint(picture, element, float(low[0]), float(low[1]))


@dataclass(frozen=True)
class BoardScene:
    """
    A board before a camera.

    Parameters
    ----------
    board : BoardPrint
        What is printed on it.
    model : CameraModel
        The camera.
    black, white, surroundings : float
        Mean signal of the board's ink and paper and of what is behind it, DN.
    blur : float
        Sigma of the lens' point spread, px.
    sensor : Sensor
        What turns the light into numbers.
    samples : int
        Rays to a pixel along x and y.

    """

    board: BoardPrint
    model: CameraModel
    black: float = 30.0
    white: float = 190.0
    surroundings: float = 90.0
    blur: float = 0.6
    sensor: Sensor = Sensor()
    samples: int = 4

    def truth(self, points: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
        """
        Return where points of the board are imaged.

        Parameters
        ----------
        points : (N, 2) array
            mm on the board.
        pose : Pose
            Of the board.

        Returns
        -------
        (N, 2) array
            px; NaN where the lens has no picture of a point.

        """
        flat = np.column_stack([points, np.zeros(len(points))])
        return self.model.project(flat @ pose.matrix.T + pose.translation)

    def mean(self, pose: Pose) -> NDArray[np.float32]:
        """Return the (h, w) mean signal, DN: area samples of the blurred picture."""
        model, count = self.model, self.samples
        picture = np.full((model.height, model.width), self.surroundings, dtype=np.float32)
        region = self._region(pose)
        if region is None:
            return picture
        rays = _rays(_Lens.of(model), count)
        y, x = (slice(count * side.start, count * side.stop) for side in region)
        # The plane of the board: what is at (X, Y, 1) on it is seen along [r1 r2 t] (X, Y, 1).
        onto = np.linalg.inv(np.column_stack([pose.matrix[:, :2], pose.translation]))
        onto = onto.astype(np.float32)
        u, v = rays[0][y, x], rays[1][y, x]
        depth = onto[2, 0] * u + onto[2, 1] * v + onto[2, 2]
        depth[depth <= 0.0] = np.nan  # seen from behind, or not at all
        element, left, top = self.board.element, self.board.left, self.board.top
        across = (onto[0, 0] * u + onto[0, 1] * v + onto[0, 2]) / depth
        down = (onto[1, 0] * u + onto[1, 1] * v + onto[1, 2]) / depth
        across, down = (across - left) / element - 0.5, (down - top) / element - 0.5
        inks = self.black + (self.white - self.black) / 255.0 * self.board.reflectance
        seen = cv2.remap(
            inks.astype(np.float32),
            np.nan_to_num(across, nan=-9.0),
            np.nan_to_num(down, nan=-9.0),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=self.surroundings,
        )
        if self.blur > 0.0:
            seen = cv2.GaussianBlur(
                seen, (0, 0), self.blur * count, borderType=cv2.BORDER_REPLICATE
            )
        size = (seen.shape[1] // count, seen.shape[0] // count)
        picture[region] = cv2.resize(seen, size, interpolation=cv2.INTER_AREA)
        return picture

    def frame(self, pose: Pose, random: np.random.Generator) -> Pixels:
        """Return the (h, w) pixels of a frame, DN."""
        return self.sensor.expose(self.mean(pose), random)

    def _region(self, pose: Pose) -> tuple[slice, slice] | None:
        """Return the rows and columns of the picture that the board reaches, or None."""
        steps = np.linspace(0.0, 1.0, 41)
        edge = np.column_stack([steps, np.zeros(41)])
        outline = np.vstack([edge, 1.0 - edge, edge[:, ::-1], 1.0 - edge[:, ::-1]])
        corner = (self.board.left, self.board.top)
        places = self.truth(outline * self.board.size + corner, pose)
        if np.isnan(places).any():  # partly out of sight: look everywhere
            return slice(0, self.model.height), slice(0, self.model.width)
        rim = RIM_SIGMA * self.blur + 2.0
        low = np.maximum(np.floor(places.min(axis=0) - rim), 0).astype(int)
        size = (self.model.width, self.model.height)
        high = np.minimum(np.ceil(places.max(axis=0) + rim) + 1, size).astype(int)
        if (high <= low).any():
            return None
        return slice(low[1], high[1]), slice(low[0], high[0])


@dataclass(frozen=True)
class _Lens:
    """What the rays of a camera depend on, in a form that a cache can keep."""

    size: tuple[int, int]
    matrix: tuple[float, ...]
    distortion: tuple[float, ...]
    equidistant: bool

    @classmethod
    def of(cls, model: CameraModel) -> _Lens:
        return cls(
            (model.width, model.height),
            tuple(np.ravel(model.matrix).tolist()),
            tuple(np.ravel(model.distortion).tolist()),
            model.distortion_model == 'equidistant',
        )


@lru_cache(maxsize=1)  # the poses of one camera follow each other
def _rays(lens: _Lens, count: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """
    Return X / Z and Y / Z of the rays through count x count places in each pixel.

    No two of a pixel share a row or a column: an edge along the rows moves the picture in steps
    of 1 / count^2 px, not 1 / count.
    """
    width, height = lens.size
    # A lens is smooth: a cubic spline over every fourth pixel is true to 1e-6 px, and ten times
    # faster than as many rays as there are.
    x, y = (np.arange(-KNOTS_PX, side + 2 * KNOTS_PX, KNOTS_PX) for side in (width, height))
    knots = _undistorted(np.stack(np.meshgrid(x, y), axis=-1).astype(float), lens)
    shift = (np.arange(count) + 0.5) / count
    rays = []
    for knot in np.moveaxis(knots, -1, 0):
        spline = RectBivariateSpline(y, x, knot)
        ray = np.empty((height * count, width * count), dtype=np.float32)
        for row in range(count):
            for column in range(count):
                ray[row::count, column::count] = spline(
                    np.arange(height) + (row + shift[column]) / count - 0.5,
                    np.arange(width) + (column + shift[row]) / count - 0.5,
                )
        rays.append(ray)
    return rays[0], rays[1]


def _undistorted(pixels: NDArray[np.float64], lens: _Lens) -> NDArray[np.float64]:
    """Return X / Z and Y / Z, (..., 2), of the rays that lead to pixels (..., 2)."""
    matrix, distortion = np.reshape(lens.matrix, (3, 3)), np.array(lens.distortion)
    criteria = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, 100, CLOSE_ENOUGH)
    flat = pixels.reshape(-1, 1, 2)
    if lens.equidistant:
        rays = cv2.fisheye.undistortPoints(flat, matrix, distortion, criteria=criteria)
    else:
        # OpenCV 4 calls what takes criteria by another name.
        undistort: Any = getattr(cv2, 'undistortPointsIter', cv2.undistortPoints)
        rays = undistort(flat, matrix, distortion, R=np.eye(3), P=np.eye(3), criteria=criteria)
    return np.asarray(rays, dtype=float).reshape(pixels.shape)

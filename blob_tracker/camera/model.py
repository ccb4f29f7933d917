"""The calibrated camera: a place in the picture becomes a direction."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from blob_tracker.camera.calibration_file import CalibrationError, read_calibration
from blob_tracker.camera.lens import DISTORTION_MODELS, unproject
from blob_tracker.types import Bearing, Location
import numpy as np
from numpy.typing import NDArray

MRAD = 1000.0  # per radian


@dataclass(frozen=True)
class CameraModel:
    """
    Pinhole camera with lens distortion, of the full, unbinned sensor.

    Parameters
    ----------
    width, height : int
        Size that was calibrated, px.
    matrix : (3, 3) array
        Camera matrix K: focal lengths and principal point, px.
    distortion : (n,) array
        Coefficients in the order k1 k2 p1 p2 k3 ...; empty or all zero is an ideal lens.
    distortion_model : str
        plumb_bob or rational_polynomial.
    name : str
        Name of the camera.
    rectification : (3, 3) array, optional
        R of a stereo pair, which no bearing needs; identity where it is left out.
    projection : (3, 4) array, optional
        P of the rectified images, which no bearing needs; K and a zero column where it is left
        out.

    Raises
    ------
    CalibrationError
        Where the size, a focal length, a coefficient or the model's name cannot be.

    """

    width: int
    height: int
    matrix: NDArray[np.float64]
    distortion: NDArray[np.float64] = field(default_factory=lambda: np.zeros(5))
    distortion_model: str = 'plumb_bob'
    name: str = 'camera'
    rectification: NDArray[np.float64] | None = None
    projection: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        if self.width <= 0 or self.height <= 0:
            raise CalibrationError(
                f'the calibrated size is {self.width} x {self.height} px; it must be positive'
            )
        if np.shape(self.matrix) != (3, 3) or not np.isfinite(self.matrix).all():
            raise CalibrationError('K must be 3 x 3 finite numbers')
        if not (self.matrix[0, 0] > 0 and self.matrix[1, 1] > 0):
            raise CalibrationError(
                f'the focal lengths are {self.matrix[0, 0]:g} and {self.matrix[1, 1]:g} px; both '
                'must be above 0 (a camera that is not calibrated has 0: set camera_info_url)'
            )
        if self.distortion_model not in DISTORTION_MODELS:
            names = ', '.join(name for name in DISTORTION_MODELS if name)
            raise CalibrationError(
                f"no distortion model '{self.distortion_model}'; there is {names}"
            )
        if not np.isfinite(self.distortion).all():
            raise CalibrationError('the distortion coefficients must be finite')
        allowed = DISTORTION_MODELS[self.distortion_model]
        if len(self.distortion) not in allowed:
            raise CalibrationError(
                f'{self.distortion_model} has {" or ".join(map(str, allowed))} coefficients, '
                f'not {len(self.distortion)}'
            )

    @classmethod
    def from_yaml(cls, path: str | Path) -> CameraModel:
        """
        Read a calibration file in the form of ROS' camera_calibration_parsers.

        Parameters
        ----------
        path : str or Path
            The YAML file.

        Returns
        -------
        CameraModel
            The camera it describes.

        Raises
        ------
        CalibrationError
            Where the file is missing, is not such YAML, or holds impossible values.

        """
        content = read_calibration(path)
        try:
            return cls(**content)
        except CalibrationError as error:
            raise CalibrationError(f'{path}: {error}') from None

    @classmethod
    def from_field_of_view(cls, width: int, height: int, degrees: float) -> CameraModel:
        """
        Return an ideal lens that sees this angle across the width, as a data sheet gives it.

        With the half-width w / 2 at half the angle, f = w / (2 tan(angle / 2)) (thesis, eq. 2.2).

        Parameters
        ----------
        width, height : int
            Size of the frames, px.
        degrees : float
            Horizontal field of view, above 0 and below 180.

        Raises
        ------
        CalibrationError
            Where the angle or the size cannot be.

        """
        if not 0.0 < degrees < 180.0:
            raise CalibrationError(f'the field of view is {degrees} degrees; it must be 0 to 180')
        focal_length = 0.5 * width / np.tan(0.5 * np.radians(degrees))
        return cls(width, height, pinhole_matrix(focal_length, width, height))

    @property
    def rectification_matrix(self) -> NDArray[np.float64]:
        """R, (3, 3): identity unless the calibration has another."""
        return np.eye(3) if self.rectification is None else self.rectification

    @property
    def projection_matrix(self) -> NDArray[np.float64]:
        """P, (3, 4): K and a zero column unless the calibration has another."""
        if self.projection is None:
            return np.hstack([self.matrix, np.zeros((3, 1))])
        return self.projection

    def project(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Image rays, or points, of the optical frame.

        Parameters
        ----------
        rays : (N, 3) array
            X right, Y down, Z forward, of any length and unit.

        Returns
        -------
        (N, 2) array
            px on the full, unbinned sensor, which may lie outside of the image; NaN where the
            lens has no picture of the ray: behind a pinhole camera, or beyond the angle at which
            the distortion model folds over.

        """
        raise NotImplementedError

    def angles(
        self, x: float, y: float
    ) -> tuple[float, float, NDArray[np.float64]]:
        """
        Return the direction in which a pixel looks, and how it turns with the pixel.

        With the ray (x', y', 1) through the pixel and h^2 = 1 + x'^2,

            azimuth = atan2(x', 1),  elevation = atan2(-y', h)

        Parameters
        ----------
        x, y : float
            px on the full, unbinned sensor.

        Returns
        -------
        float, float, (2, 2) array
            Azimuth and elevation in mrad, and their derivative by x and y in mrad/px.

        Raises
        ------
        LensError
            Where the distortion model leads no ray to that pixel.

        """
        distortion = np.asarray(self.distortion, dtype=float)
        (x, y), by_pixel = unproject(np.array([x, y]), self.matrix, distortion)
        h = np.hypot(1.0, x)
        by_ray = np.array(
            [
                [1.0 / h**2, 0.0],
                [x * y / (h * (h**2 + y**2)), -h / (h**2 + y**2)],
            ]
        )
        azimuth, elevation = MRAD * np.arctan2(x, 1.0), MRAD * np.arctan2(-y, h)
        return float(azimuth), float(elevation), MRAD * by_ray @ by_pixel

    def bearing(self, location: Location) -> Bearing:
        """
        Return the direction in which a location is seen.

        Parameters
        ----------
        location : Location
            px on the full, unbinned sensor.

        Returns
        -------
        Bearing
            mrad; the covariance, in mrad^2, is the location's, carried through the derivative.

        Raises
        ------
        LensError
            Where the distortion model leads no ray to that pixel.

        """
        azimuth, elevation, derivative = self.angles(location.x, location.y)
        return Bearing(
            azimuth=azimuth,
            elevation=elevation,
            covariance=derivative @ location.covariance @ derivative.T,
            stamp_ns=location.stamp_ns,
        )


def pinhole_matrix(focal_length: float, width: int, height: int) -> NDArray[np.float64]:
    """Return the camera matrix of square pixels with the axis through the middle, px."""
    return np.array(
        [
            [focal_length, 0.0, 0.5 * (width - 1)],
            [0.0, focal_length, 0.5 * (height - 1)],
            [0.0, 0.0, 1.0],
        ]
    )

"""The calibrated camera: a place in the picture becomes a direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import atan2, cos, hypot, inf, isfinite, nan, sin, sqrt
from pathlib import Path
import warnings

from blob_tracker.camera.calibration_reader import read_calibration
from blob_tracker.camera.lens import LensError, LENSES, polynomial
from blob_tracker.camera.lens.definition import Coefficients, Derivative, Vector
from blob_tracker.camera.plausibility import doubts
from blob_tracker.camera.yaml_file import CalibrationError
from blob_tracker.kernel import exact_kernel
from blob_tracker.types import Bearing, Location
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from numpy.typing import NDArray

# Of a focal length of 1e9 px: what turns by less has a matrix of no lens, from which an
# angle of 90 degrees would come, with a variance of 0.
LEAST_TURN_MRAD_PER_PX = 1e-6


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
        Coefficients in the order of OpenCV: k1 k2 p1 p2 k3 ..., of an equidistant lens k1 k2 k3
        k4; empty is the same as all zero.
    distortion_model : str
        One of `blob_tracker.camera.lens.LENSES`.
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
        If the size, a focal length, a coefficient or the model's name is invalid.

    Examples
    --------
    A light 60 px to the right of the axis of a lens of 600 px:

    >>> model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> azimuth, elevation, _ = model.angles(319.5 + 60.0, 239.5)
    >>> round(azimuth, 2), round(abs(elevation), 2)  # mrad
    (99.67, 0.0)

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
        below = self.matrix[1, 0], self.matrix[2, 0], self.matrix[2, 1], self.matrix[2, 2]
        if below != (0.0, 0.0, 0.0, 1.0):
            raise CalibrationError('K must be 0 below its diagonal and end in 1')
        for name, value, shape in (
            ('R', self.rectification, (3, 3)),
            ('P', self.projection, (3, 4)),
        ):
            if value is not None and (np.shape(value) != shape or not np.isfinite(value).all()):
                raise CalibrationError(f'{name} must be {shape[0]} x {shape[1]} finite numbers')
        if self.distortion_model not in LENSES:
            names = ', '.join(name for name in LENSES if name)
            raise CalibrationError(
                f'no distortion model {self.distortion_model!r:.40}; there is {names}'
            )
        if not np.isfinite(self.distortion).all():
            raise CalibrationError('the distortion coefficients must be finite')
        if not self.distortion_model:
            if np.any(self.distortion):
                names = ', '.join(name for name in LENSES if name)
                raise CalibrationError(
                    f'there are {len(self.distortion)} distortion coefficients and no distortion '
                    f'model; name theirs: {names}'
                )
            # Some drivers fill up the coefficients of a lens that has none.
            object.__setattr__(self, 'distortion', np.zeros(0))
        allowed = LENSES[self.distortion_model].counts
        if len(self.distortion) not in allowed:
            raise CalibrationError(
                f'distortion model {self.distortion_model!r} has '
                f'{" or ".join(map(str, allowed))} coefficients, '
                f'not {len(self.distortion)}'
            )

    @classmethod
    def from_file(
        cls, path: str | Path, *, camera: str = '', size: tuple[int, int] | None = None,
        warn: Callable[[str], object] = warnings.warn,
    ) -> CameraModel:
        """
        Read a calibration file of ROS or of another program.

        Parameters
        ----------
        path : str or Path
            In one of the forms that `read_calibration` knows.
        camera : str
            Name of the camera that is meant in a file of several.
        size : (int, int), optional
            Width and height, px, that count where the file has none.
        warn : callable
            Is told what ought to be known of the file, a sentence each time.

        Returns
        -------
        CameraModel
            The camera it describes.

        Raises
        ------
        CalibrationError
            If the file is missing, is in no such form, or holds impossible values.

        """
        found = read_calibration(path, camera=camera, size=size)
        try:
            model = cls(**found.arguments)
            unusual = model.doubts()
        except CalibrationError as error:
            raise CalibrationError(f'{path}: {error}') from None
        for remark in [*found.remarks, *(f'{path}: {each}' for each in unusual)]:
            warn(remark)
        return model

    @classmethod
    def from_field_of_view(
        cls, width: int, height: int, degrees: float, pixel_aspect: float = 1.0
    ) -> CameraModel:
        """
        Return an ideal lens that sees this angle across the width, as a data sheet gives it.

        With the half-width w / 2 at half the angle, f = w / (2 tan(angle / 2)) (thesis, eq. 2.2).

        Parameters
        ----------
        width, height : int
            Size of the frames, px.
        degrees : float
            Horizontal field of view, above 0 and below 180.
        pixel_aspect : float
            Height of a pixel by its width.

        Raises
        ------
        CalibrationError
            If the angle or the size is invalid.

        """
        if not 0.0 < degrees < 180.0:
            raise CalibrationError(f'the field of view is {degrees} degrees; it must be 0 to 180')
        focal_length = 0.5 * width / np.tan(0.5 * np.radians(degrees))
        matrix = pinhole_matrix(focal_length, width, height)
        matrix[1, 1] /= pixel_aspect
        return cls(width, height, matrix)

    @classmethod
    def from_data_sheet(
        cls, width: int, height: int, focal_length_mm: float, pixel_um: float
    ) -> CameraModel:
        """
        Return an ideal lens of this focal length before pixels of this pitch.

        How far its bearings can be trusted, `blob_tracker.camera.DataSheet` tells.

        Parameters
        ----------
        width, height : int
            Size of the full sensor, px.
        focal_length_mm : float
            mm, above 0.
        pixel_um : float
            Pitch of the square pixels, um, above 0.

        Raises
        ------
        CalibrationError
            If a length or the size is invalid.

        """
        for name, value, unit in (
            ('focal length', focal_length_mm, 'mm'), ('pixel size', pixel_um, 'um')
        ):
            if not 0.0 < value < np.inf:
                raise CalibrationError(f'the {name} is {value:g} {unit}; it must be above 0')
        return cls(width, height, pinhole_matrix(1e3 * focal_length_mm / pixel_um, width, height))

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
        rays = np.asarray(rays, dtype=float).reshape(-1, 3)
        places = LENSES[self.distortion_model].image(rays, self._coefficients)
        return np.asarray(places @ self.matrix[:2, :2].T + self.matrix[:2, 2])

    def doubts(self) -> list[str]:
        """Return what is unusual about it; raises CalibrationError where it cannot be right."""
        return doubts(self.matrix, self.width, self.height, self.unproject)

    def unproject(
        self, x: float, y: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """
        Return the ray that is imaged on a pixel: the way back of `project`.

        Parameters
        ----------
        x, y : float
            px on the full, unbinned sensor.

        Returns
        -------
        (3,) array, (3, 2) array
            The ray (X, Y, Z), of any length, and its derivative by x and y, 1/px.

        Raises
        ------
        LensError
            If the distortion model leads no ray to that pixel.

        """
        ray, derivative = self._ray(x, y)
        inverse = np.linalg.inv(self.matrix[:2, :2])
        return np.array(ray), np.asarray(np.array(derivative) @ inverse)

    def angles(
        self, x: float, y: float
    ) -> tuple[float, float, NDArray[np.float64]]:
        """
        Return the direction in which a pixel looks, and how it turns with the pixel.

        With the ray (X, Y, Z) through the pixel and h^2 = X^2 + Z^2,

            azimuth = atan2(X, Z),  elevation = atan2(-Y, h)

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
            If the distortion model leads no ray to that pixel, or one straight up or down,
            which has no azimuth, or K is finite but that of no lens.

        """
        azimuth, elevation, by_azimuth, by_elevation = _turned(
            *self._ray(x, y), self._intrinsics
        )
        self._check_turns(x, y, by_azimuth, by_elevation)
        return azimuth, elevation, np.array([by_azimuth, by_elevation])

    def _check_turns(
        self, x: float, y: float, by_azimuth: tuple[float, float],
        by_elevation: tuple[float, float],
    ) -> None:
        """Raise LensError if the angles turn with the pixel as behind no lens."""
        (a, b), (c, d) = by_azimuth, by_elevation
        if (
            hypot(a, b) > LEAST_TURN_MRAD_PER_PX and hypot(c, d) > LEAST_TURN_MRAD_PER_PX
            and LEAST_TURN_MRAD_PER_PX**2 < abs(a * d - b * c) < inf
        ):
            return
        (ray_x, _, ray_z), _ = self._ray(x, y)
        if ray_x * ray_x + ray_z * ray_z == 0.0:
            raise LensError(f'the pixel ({x:.1f}, {y:.1f}) looks straight up or down: no azimuth')
        raise LensError(
            f'the direction at the pixel ({x:.1f}, {y:.1f}) turns by {[[a, b], [c, d]]} '
            'mrad/px, which no lens does; focal lengths, skew, principal point or distortion '
            'are out of all proportion'
        )

    def place(
        self, azimuth: float, elevation: float
    ) -> tuple[float, float, NDArray[np.float64]]:
        """
        Return the pixel that looks in a direction: the way back of `angles`.

        Parameters
        ----------
        azimuth, elevation : float
            mrad.

        Returns
        -------
        float, float, (2, 2) array
            x and y in px on the full, unbinned sensor, which may lie outside of the image, and
            their derivative by azimuth and elevation in px/mrad.

        Raises
        ------
        LensError
            If the lens has no picture of that direction.

        """
        x = y = nan
        if isfinite(azimuth + elevation):
            a, e = azimuth / MRAD_PER_RAD, elevation / MRAD_PER_RAD
            ray = np.array([[cos(e) * sin(a), -sin(e), cos(e) * cos(a)]])
            x, y = self.project(ray)[0].tolist()
        if not isfinite(x + y):
            raise LensError(
                f'the lens has no picture of the direction ({azimuth:.1f}, {elevation:.1f}) mrad'
            )
        return x, y, np.asarray(np.linalg.inv(self.angles(x, y)[2]), dtype=np.float64)

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
            As `angles` does.

        """
        x, y = location.x, location.y
        (xx, xy), (yx, yy) = location.covariance.tolist()
        azimuth, elevation, by_azimuth, by_elevation, covariance = _carried(
            *self._ray(x, y), self._intrinsics, (xx, xy, yx, yy)
        )
        self._check_turns(x, y, by_azimuth, by_elevation)
        return Bearing(azimuth, elevation, covariance, location.stamp_ns)

    @cached_property
    def _coefficients(self) -> Coefficients:
        """Return the distortion, hashable."""
        return tuple(float(value) for value in self.distortion)

    @cached_property
    def _intrinsics(self) -> tuple[float, float, float, float, float]:
        """Return focal lengths, skew and principal point, px."""
        (focal_x, skew, centre_x), (_, focal_y, centre_y), _ = self.matrix.tolist()
        return focal_x, focal_y, skew, centre_x, centre_y

    def _ray(self, x: float, y: float) -> tuple[Vector, Derivative]:
        """Return the ray onto a pixel, and its derivative by the place in focal lengths."""
        focal_x, focal_y, skew, centre_x, centre_y = self._intrinsics
        place_y = (y - centre_y) / focal_y
        place_x = (x - centre_x - skew * place_y) / focal_x
        found = LENSES[self.distortion_model].ray(place_x, place_y, self._coefficients)
        if found is None:
            raise LensError(
                f'no ray leads to the pixel ({x:.1f}, {y:.1f}): '
                'the distortion coefficients do not hold there'
            )
        return found


def pinhole_matrix(focal_length: float, width: int, height: int) -> NDArray[np.float64]:
    """
    Return the camera matrix of square pixels with the axis through the middle, px.

    Examples
    --------
    >>> pinhole_matrix(600.0, 640, 480)[0].tolist()
    [600.0, 0.0, 319.5]

    """
    return np.array(
        [
            [focal_length, 0.0, 0.5 * (width - 1)],
            [0.0, focal_length, 0.5 * (height - 1)],
            [0.0, 0.0, 1.0],
        ]
    )


@exact_kernel
def _turned(
    ray: Vector, derivative: Derivative, intrinsics: tuple[float, float, float, float, float]
) -> tuple[float, float, tuple[float, float], tuple[float, float]]:
    """
    Return the direction of a ray, and how it turns with the pixel.

    Parameters
    ----------
    ray, derivative : tuple
        See `Lens.ray`.
    intrinsics : (float, float, float, float, float)
        Focal lengths, skew and principal point, px.

    Returns
    -------
    float, float, (float, float), (float, float)
        Azimuth and elevation, mrad, and the derivative of either by x and y, mrad/px; NaN
        straight up or down.

    """
    ray_x, ray_y, ray_z = ray
    h2 = ray_x * ray_x + ray_z * ray_z
    if h2 == 0.0:
        return nan, nan, (nan, nan), (nan, nan)
    h, length2 = sqrt(h2), h2 + ray_y * ray_y
    # The derivative of both angles by the ray, times that of the ray by the place.
    turn_x, turn_z = MRAD_PER_RAD * ray_z / h2, -MRAD_PER_RAD * ray_x / h2
    lift = MRAD_PER_RAD * ray_y / (h * length2)
    lift_x, lift_y, lift_z = lift * ray_x, -MRAD_PER_RAD * h / length2, lift * ray_z
    (xx, xy), (yx, yy), (zx, zy) = derivative
    azimuth_x, azimuth_y = turn_x * xx + turn_z * zx, turn_x * xy + turn_z * zy
    elevation_x = lift_x * xx + lift_y * yx + lift_z * zx
    elevation_y = lift_x * xy + lift_y * yy + lift_z * zy
    focal_x, focal_y, skew = intrinsics[:3]
    slant = skew / focal_x / focal_y
    by_azimuth = azimuth_x / focal_x, azimuth_y / focal_y - azimuth_x * slant
    by_elevation = elevation_x / focal_x, elevation_y / focal_y - elevation_x * slant
    return (
        MRAD_PER_RAD * atan2(ray_x, ray_z), MRAD_PER_RAD * atan2(-ray_y, h), by_azimuth,
        by_elevation,
    )


@exact_kernel
def _carried(
    ray: Vector, derivative: Derivative, intrinsics: tuple[float, float, float, float, float],
    covariance: tuple[float, float, float, float],
) -> tuple[float, float, tuple[float, float], tuple[float, float], NDArray[np.float64]]:
    """Return what `_turned` does, and a covariance, px^2, carried through it: mrad^2."""
    azimuth, elevation, (a, b), (c, d) = _turned(ray, derivative, intrinsics)
    xx, xy, yx, yy = covariance
    azimuth_x, azimuth_y = a * xx + b * yx, a * xy + b * yy
    elevation_x, elevation_y = c * xx + d * yx, c * xy + d * yy
    carried = np.empty((2, 2))
    carried[0, 0], carried[0, 1] = azimuth_x * a + azimuth_y * b, azimuth_x * c + azimuth_y * d
    carried[1, 0] = elevation_x * a + elevation_y * b
    carried[1, 1] = elevation_x * c + elevation_y * d
    return azimuth, elevation, (a, b), (c, d), carried


def compile_lens() -> None:
    """Compile what leads from a pixel to its bearing, or load it."""
    polynomial.compile_lens()
    model = CameraModel(3, 3, pinhole_matrix(1.0, 3, 3))
    model.angles(0.0, 0.0)
    model.bearing(Location(0.0, 0.0, np.eye(2), 1.0, 0.0, 1.0, 1.0, 1.0, 0))

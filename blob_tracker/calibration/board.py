"""
The camera from views of a board: focal lengths, principal point, distortion, and how well each.

OpenCV finds the parameters that make the sum of squared distances between the points and their
projections least (Zhang, IEEE Trans. PAMI 22 (2000) 1330). Their covariance is

    Cov = s^2 (J^T J)^-1,   s^2 = sum of squared residuals / (2 N - parameters)

with J the derivative of all projections by all parameters, the poses of the board included, which
are then left out. OpenCV's own standard deviations are the same from some version after 4.6 on; in
4.6 they are sqrt(2) and more too large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from blob_tracker.calibration.boards import View
from blob_tracker.calibration.dot_centres import centre_offsets
from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.camera.model import MRAD
import cv2
import numpy as np
from numpy.typing import NDArray

# Model: names of its coefficients, in OpenCV's order.
COEFFICIENTS = {
    'equidistant': ('k1', 'k2', 'k3', 'k4'),
    'plumb_bob': ('k1', 'k2', 'p1', 'p2', 'k3'),
    'rational_polynomial': ('k1', 'k2', 'p1', 'p2', 'k3', 'k4', 'k5', 'k6'),
}
INTRINSICS = ('fx', 'fy', 'cx', 'cy')
LEAST_VIEWS = 3
CRITERIA = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, 200, 1e-12)
OUTLIER = 3.0  # times the median rms of the views: noise alone does not reach 2
HARMLESS = 0.1  # px: a view this good is not at fault where the others are better still
DOT_PASSES = 2  # the offsets of dots hang on the camera a little

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BoardCalibration:
    """
    A camera, as views of a board tell it.

    Parameters
    ----------
    model : CameraModel
        The camera.
    names : tuple of str
        Of the parameters: fx, fy, cx, cy in px, then the distortion coefficients.
    covariance : (n, n) array
        Of the parameters in that order.
    rms : float
        Root of the mean squared distance between a point and its projection, px.
    sigma : float
        Standard deviation of one coordinate of one point, px, as the residuals tell it.
    views : tuple of View
        Those that took part; dots moved onto the pictures of their centres.
    residuals : tuple of (N, 2) arrays
        Of each view: place less projection, px.
    rotations, translations : (M, 3) arrays
        Of the board in each view: rotation vector, rad, and place of its origin, mm.
    left_out : tuple of (View, float)
        Views that do not fit the others, with their rms, px.

    """

    model: CameraModel
    names: tuple[str, ...]
    covariance: Array
    rms: float
    sigma: float
    views: tuple[View, ...]
    residuals: tuple[Array, ...]
    rotations: Array
    translations: Array
    left_out: tuple[tuple[View, float], ...] = ()

    @property
    def values(self) -> Array:
        """Return the parameters, in the order of `names`."""
        return _parameters(self.model)

    @property
    def sigmas(self) -> Array:
        """Return the standard deviation of each parameter."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def view_rms(self) -> Array:
        """Return the rms distance of each view, (M,), px."""
        return np.array([_rms(residual) for residual in self.residuals])

    @property
    def normals(self) -> Array:
        """Return the board's normal, away from the camera, in the optical frame, (M, 3)."""
        normals = np.array([cv2.Rodrigues(rotation)[0][:, 2] for rotation in self.rotations])
        return np.asarray(normals * np.where(normals[:, 2:] < 0.0, -1.0, 1.0))

    def bearing_covariance(self, x: float, y: float) -> Array:
        """
        Return the covariance that the calibration alone gives the bearing of a pixel.

        The derivative of a bearing by a parameter is that by the pixel times, with its sign
        turned, that of the projection by the parameter: the light still comes in along its ray.

        Parameters
        ----------
        x, y : float
            px.

        Returns
        -------
        (2, 2) array
            mrad^2, order azimuth, elevation, of the direction in the camera's optical frame.

        Raises
        ------
        LensError
            Where no ray leads to that pixel.

        """
        azimuth, elevation, by_pixel = self.model.angles(x, y)
        across = np.tan(azimuth / MRAD)
        ray = np.array([across, -np.tan(elevation / MRAD) * np.hypot(1.0, across), 1.0])
        _, by_parameter, _ = project(ray[None], np.zeros(3), np.zeros(3), self.model)
        derivative = by_pixel @ by_parameter
        return np.asarray(derivative @ self.covariance @ derivative.T)


def calibrate_board(
    views: Sequence[View], distortion_model: str = 'plumb_bob', name: str = 'camera'
) -> BoardCalibration:
    """
    Find the camera that sees a board as these views show it.

    A view whose rms is beyond 0.1 px and three times the median is left out, and told of. Dots are moved
    from the centroids of their pictures onto the pictures of their centres.

    Parameters
    ----------
    views : sequence of View
        Three or more, of images of one size.
    distortion_model : str
        plumb_bob, rational_polynomial or equidistant.
    name : str
        Of the camera.

    Returns
    -------
    BoardCalibration
        Camera, covariance, residuals and poses.

    Raises
    ------
    CalibrationError
        Where the views are too few, of several sizes, or do not tell the camera.

    """
    if len(views) < LEAST_VIEWS:
        raise CalibrationError(
            f'the board was found in {len(views)} images; it takes {LEAST_VIEWS} at the very '
            'least, and 10 or more, each tilted another way, for a good calibration'
        )
    check_sizes(views)
    used = list(views)
    left_out: list[tuple[View, float]] = []
    while True:
        found = _refined(used, distortion_model, name)
        rms = found.view_rms
        worst = int(np.argmax(rms))
        limit = max(OUTLIER * float(np.median(rms)), HARMLESS)
        if rms[worst] <= limit or len(used) <= LEAST_VIEWS:
            return replace(found, left_out=tuple(left_out))
        left_out.append((used.pop(worst), float(rms[worst])))


def check_sizes(views: Sequence[View]) -> None:
    """Raise CalibrationError where the images are not all of one size."""
    sizes: dict[tuple[int, int], list[str]] = {}
    for view in views:
        sizes.setdefault(view.size, []).append(view.name)
    if len(sizes) > 1:
        groups = ', '.join(
            f'{len(names)} of {width} x {height} px ({names[0]})'
            for (width, height), names in sorted(sizes.items(), key=lambda each: -len(each[1]))
        )
        raise CalibrationError(
            f'the images have several sizes: {groups}; a calibration is for one: leave the others '
            'out'
        )


def project(
    points: Array, rotation: Array, translation: Array, model: CameraModel
) -> tuple[Array, Array, Array]:
    """
    Image the points of a board, with all derivatives.

    Parameters
    ----------
    points : (N, 3) array
        mm on the board.
    rotation, translation : (3,) array
        Of the board.
    model : CameraModel
        The camera.

    Returns
    -------
    (N, 2) array, (2 N, n) array, (2 N, 6) array
        Places in px; their derivatives by fx, fy, cx, cy and the distortion coefficients, and
        by rotation and translation.

    """
    distortion = np.asarray(model.distortion, dtype=float)
    if model.distortion_model == 'equidistant':
        places, jacobian = cv2.fisheye.projectPoints(
            points[:, None], rotation, translation, model.matrix, distortion
        )
        # Its order: focal lengths, principal point, coefficients, rotation, translation, skew.
        by_camera, by_pose = jacobian[:, :8], jacobian[:, 8:14]
    else:
        places, jacobian = cv2.projectPoints(
            points, rotation, translation, model.matrix, distortion
        )
        by_camera, by_pose = jacobian[:, 6:10 + len(distortion)], jacobian[:, :6]
    flat = np.asarray(places, dtype=float).reshape(-1, 2)
    return flat, np.asarray(by_camera, dtype=float), np.asarray(by_pose, dtype=float)


def _refined(views: Sequence[View], distortion_model: str, name: str) -> BoardCalibration:
    """Calibrate; with dots, as often as it takes to know the pictures of their centres."""
    found = _fitted(views, distortion_model, name)
    diameter = float(np.median([view.diameter for view in views]))
    if not diameter:
        return found
    for _ in range(DOT_PASSES):
        centred = [
            replace(view, places=view.places - centre_offsets(
                view.points, diameter, rotation, translation, found.model
            ))
            for view, rotation, translation in zip(views, found.rotations, found.translations)
        ]
        found = _fitted(centred, distortion_model, name)
    return found


def _fitted(views: Sequence[View], distortion_model: str, name: str) -> BoardCalibration:
    """Calibrate with all of these views."""
    points = [np.column_stack([view.points, np.zeros(len(view.points))]) for view in views]
    size = views[0].size
    fault = (
        'the views do not tell the camera: the board must be tilted by 20 to 45 degrees in most '
        'of them, to the left, to the right, up and down'
    )
    try:
        matrix, distortion, rotations, translations = _estimate(
            points, [view.places for view in views], size, distortion_model
        )
        model = CameraModel(*size, matrix, distortion, distortion_model, name)
    except (cv2.error, CalibrationError):
        raise CalibrationError(fault) from None
    if distortion_model == 'equidistant' and not _all_in_front(points, rotations, translations):
        raise CalibrationError(fault)
    normal = np.zeros((4 + len(distortion),) * 2)
    residuals = []
    for view, on_board, rotation, translation in zip(views, points, rotations, translations):
        places, by_camera, by_pose = project(on_board, rotation, translation, model)
        residuals.append(view.places - places)
        # What a change of pose cannot make up for (the Schur complement of the poses).
        beyond = by_camera - by_pose @ np.linalg.lstsq(by_pose, by_camera, rcond=None)[0]
        normal += beyond.T @ beyond
    squares = sum(float((residual**2).sum()) for residual in residuals)
    count = sum(len(view.points) for view in views)
    freedom = 2 * count - len(normal) - 6 * len(views)
    if freedom < 1:
        raise CalibrationError('there are fewer points than parameters; take more images')
    scale = np.sqrt(np.diag(normal))
    if not np.isfinite(normal).all() or (scale == 0.0).any():
        raise CalibrationError(fault)
    # Scaled: focal lengths in px and coefficients of r^6 differ by many powers of ten.
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-15, hermitian=True)
    covariance = squares / freedom * inverse / np.outer(scale, scale)
    return BoardCalibration(
        model=model,
        names=INTRINSICS + COEFFICIENTS[distortion_model],
        covariance=covariance,
        rms=float(np.sqrt(squares / count)),
        sigma=float(np.sqrt(squares / freedom)),
        views=tuple(views),
        residuals=tuple(residuals),
        rotations=rotations,
        translations=translations,
    )


def _estimate(
    points: Sequence[Array],
    places: Sequence[Array],
    size: tuple[int, int],
    distortion_model: str,
) -> tuple[Array, Array, Array, Array]:
    """Return K (3, 3), the coefficients (n,), rotations (M, 3) and translations (M, 3)."""
    if distortion_model == 'equidistant':
        _, matrix, distortion, rotations, translations = cv2.fisheye.calibrate(
            [each[None] for each in points],
            [each[None] for each in places],
            size,
            np.eye(3),
            np.zeros(4),
            flags=cv2.fisheye.CALIB_RECOMPUTE_EXTRINSIC | cv2.fisheye.CALIB_FIX_SKEW,
            criteria=CRITERIA,
        )
    else:
        _, matrix, distortion, rotations, translations = cv2.calibrateCamera(
            [each.astype(np.float32) for each in points],
            [each.astype(np.float32) for each in places],
            size,
            None,
            None,
            flags=cv2.CALIB_RATIONAL_MODEL if distortion_model == 'rational_polynomial' else 0,
            criteria=CRITERIA,
        )
    coefficients = np.ravel(distortion)[: len(COEFFICIENTS[distortion_model])].astype(float)
    return (
        np.asarray(matrix, dtype=float),
        coefficients,
        np.array(rotations, dtype=float).reshape(-1, 3),
        np.array(translations, dtype=float).reshape(-1, 3),
    )


def _all_in_front(
    points: Sequence[Array], rotations: Array, translations: Array
) -> bool:
    """Tell whether all points lie before the camera: a fish-eye's fit may put them behind."""
    return all(
        float((on_board @ cv2.Rodrigues(rotation)[0].T + translation)[:, 2].min()) > 0.0
        for on_board, rotation, translation in zip(points, rotations, translations)
    )


def _parameters(model: CameraModel) -> Array:
    matrix = model.matrix
    focal = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]
    return np.concatenate([focal, np.asarray(model.distortion, dtype=float)])


def _rms(residual: Array) -> float:
    """Return the rms length of (N, 2) vectors."""
    return float(np.sqrt((residual**2).sum(axis=1).mean()))

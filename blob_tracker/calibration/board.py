"""
The camera from views of a board: focal lengths, principal point, distortion, and how well each.

OpenCV finds the parameters that make the sum of squared distances between the points and their
projections least (Zhang, IEEE Trans. PAMI 22 (2000) 1330). Their covariance is

    Cov = k s^2 (J^T J)^-1,   s^2 = sum of squared residuals / (2 N - parameters)

with J the derivative of all projections by all parameters, the poses of the board included, which
are then left out, and k >= 1 the growth where the errors of a view hang together
(`view_scatter`). OpenCV's own standard deviations are the same in 4.14 and 5.0, and sqrt(2) or
more too large in 4.6, that of Ubuntu 24.04; it never tells the correlations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from blob_tracker.calibration.boards import View
from blob_tracker.calibration.bundle import adjust, Bundle, parts, project, residuals
from blob_tracker.calibration.dot_centres import centre_offsets
from blob_tracker.calibration.view_scatter import variance_growth
from blob_tracker.camera import CalibrationError, CameraModel, LensError
from blob_tracker.camera.lens import LENSES
import cv2
import numpy as np
from numpy.typing import NDArray

INTRINSICS = ('fx', 'fy', 'cx', 'cy')
LEAST_VIEWS = 3
OUTLIER = 3.0  # times the median rms of the views: noise alone does not reach 2
HARMLESS_PX = 0.1  # a view this good is not at fault where the others are better still
PRIOR_ROUNDS = 10  # most: three are the rule
SETTLED = 0.01  # of the sum of squares: half a per cent of every sigma
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
    growth : float
        Of the covariance, as the errors of the points of a view hang together; 1 if they do not.

    Examples
    --------
    What a calibration says of itself, and of the bearing of the pixel in the middle:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> found = BoardCalibration(
    ...     CameraModel(640, 480, pinhole_matrix(600.0, 640, 480), distortion=np.zeros(0)),
    ...     ('fx', 'fy', 'cx', 'cy'), np.diag([0.25, 0.25, 0.04, 0.04]), rms=0.07, sigma=0.05,
    ...     views=(), residuals=(), rotations=np.zeros((0, 3)), translations=np.zeros((0, 3)),
    ... )
    >>> found.sigmas.tolist()  # px
    [0.5, 0.5, 0.2, 0.2]
    >>> np.sqrt(found.bearing_covariance(319.5, 239.5).diagonal()).round(2).tolist()  # mrad
    [0.33, 0.33]

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
    growth: float = 1.0

    @property
    def values(self) -> Array:
        """Return the parameters, in the order of `names`."""
        return Bundle(self.model, self.rotations, self.translations).parameters

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
            If no ray leads to that pixel, or one at 90 degrees from the axis or more, which
            OpenCV does not project.

        """
        _, _, by_pixel = self.model.angles(x, y)
        ray, _ = self.model.unproject(x, y)
        if ray[2] <= 0.0:
            raise LensError(
                f'the pixel ({x:.1f}, {y:.1f}) looks 90 degrees or more away from the axis: how '
                'well its bearing is known is not computed there'
            )
        _, by_parameter, _ = project(ray[None], np.zeros(3), np.zeros(3), self.model)
        derivative = by_pixel @ by_parameter
        return np.asarray(derivative @ self.covariance @ derivative.T)


def calibrate_board(
    views: Sequence[View], distortion_model: str = 'plumb_bob', name: str = 'camera'
) -> BoardCalibration:
    """
    Find the camera that sees a board as these views show it.

    A view whose rms is beyond 0.1 px and three times the median is left out, and told of. Dots
    are moved from the centroids of their pictures onto the pictures of their centres.

    Parameters
    ----------
    views : sequence of View
        Three or more, of images of one size.
    distortion_model : str
        One of `blob_tracker.camera.lens.LENSES` that names its coefficients.
    name : str
        Of the camera.

    Returns
    -------
    BoardCalibration
        Camera, covariance, residuals and poses.

    Raises
    ------
    CalibrationError
        If the views are too few, of several sizes, or do not tell the camera.

    Examples
    --------
    Twelve views of the corners of a chessboard, each known to 0.05 px:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> from scipy.spatial.transform import Rotation
    >>> true = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> random, views = np.random.default_rng(1), []
    >>> grid = np.mgrid[-4.0:5.0, -3.0:4.0, 0.0:1.0].reshape(3, -1).T * 25.0  # mm
    >>> for turn in random.uniform(-0.6, 0.6, (12, 3)):
    ...     points = Rotation.from_rotvec(turn).apply(grid) + [0.0, 0.0, 400.0]
    ...     places = true.project(points)
    ...     views.append(View(grid[:, :2], random.normal(places, 0.05), (640, 480)))
    >>> found = calibrate_board(views)
    >>> round(found.values[0]), round(float(found.sigmas[0]), 1)  # fx and its sigma, px
    (600, 0.2)

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
        limit = max(OUTLIER * float(np.median(rms)), HARMLESS_PX)
        if rms[worst] <= limit or len(used) <= LEAST_VIEWS:
            return replace(found, left_out=tuple(left_out))
        left_out.append((used.pop(worst), float(rms[worst])))


def check_sizes(views: Sequence[View]) -> None:
    """Raise CalibrationError if the images are not all of one size."""
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
    fault = (
        'the views do not determine the camera: tilt the board by 20 to 45 degrees in most of '
        'them, to the left, to the right, up and down'
    )
    count = sum(len(view.points) for view in views)
    lens = LENSES[distortion_model]
    names = INTRINSICS + lens.names
    freedom = 2 * count - len(names) - 6 * len(views)
    if freedom < 1:
        raise CalibrationError('there are fewer points than parameters; take more images')
    prior = np.zeros(len(names))
    try:
        bundle = _estimate(views, distortion_model, name)
        if lens.sigmas:
            held = np.array([*(inf for _ in INTRINSICS), *lens.sigmas])
            squares = _squares(residuals(views, bundle))
            # The prior weighs against the scatter of the points, which only the fit itself tells:
            # that of its start holds what the start's coefficients cannot follow.
            for _ in range(PRIOR_ROUNDS):
                prior = squares / freedom / held**2
                bundle = adjust(views, bundle, prior)
                before, squares = squares, _squares(residuals(views, bundle))
                if abs(before - squares) <= SETTLED * squares:
                    break
    except (cv2.error, CalibrationError, np.linalg.LinAlgError):
        raise CalibrationError(fault) from None
    left = residuals(views, bundle)
    information, pulls = parts(views, bundle)
    normal = information.sum(axis=0) + np.diag(prior)
    scale = np.sqrt(np.diag(normal))
    if not np.isfinite(normal).all() or (scale == 0.0).any() or not _all_in_front(views, bundle):
        raise CalibrationError(fault)
    squares = _squares(left)
    # Scaled: focal lengths in px and coefficients of r^6 differ by many powers of ten.
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-15, hermitian=True)
    growth = variance_growth(information, pulls, squares / freedom, prior)
    covariance = growth * squares / freedom * inverse / np.outer(scale, scale)
    return BoardCalibration(
        model=bundle.model,
        names=names,
        covariance=covariance,
        rms=float(np.sqrt(squares / count)),
        sigma=float(np.sqrt(squares / freedom)),
        views=tuple(views),
        residuals=tuple(left),
        rotations=bundle.rotations,
        translations=bundle.translations,
        growth=growth,
    )


def _estimate(views: Sequence[View], distortion_model: str, name: str) -> Bundle:
    """Return what the fit begins with."""
    points = [np.column_stack([view.points, np.zeros(len(view.points))]) for view in views]
    size = views[0].size
    found = LENSES[distortion_model].start(points, [view.places for view in views], size)
    model = CameraModel(*size, found.matrix, found.coefficients, distortion_model, name)
    return Bundle(model, found.rotations, found.translations)


def _all_in_front(views: Sequence[View], bundle: Bundle) -> bool:
    """Tell whether the board lies before the camera: a fit without tilts may put it behind."""
    return all(
        float((view.points @ cv2.Rodrigues(rotation)[0][2, :2] + translation[2]).min()) > 0.0
        for view, rotation, translation in zip(views, bundle.rotations, bundle.translations)
    )


def _squares(left: Sequence[Array]) -> float:
    """Return the sum of squares of all residuals, px^2."""
    return sum(float((each**2).sum()) for each in left)


def _rms(residual: Array) -> float:
    """Return the rms length of (N, 2) vectors."""
    return float(np.sqrt((residual**2).sum(axis=1).mean()))

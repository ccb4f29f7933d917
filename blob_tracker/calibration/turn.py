"""Focal length and principal point from a servo that turns the camera by known angles."""

from __future__ import annotations

from dataclasses import dataclass, replace

from blob_tracker.calibration.scatter import variance_factor
from blob_tracker.calibration.turn_start import (
    check_stations, first_look, NAMES, start_values, TurnError,
)
from blob_tracker.camera import CameraModel
from blob_tracker.camera.lens import LENSES
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

STILL_RAD = 1e-3  # an axis that turned by less was not turned
ROUNDS = 3  # of the fit, each with the weights of the one before
STEP_RAD = 1e-6  # of the differences by the servo's angles
SINGULAR = 1e-9  # of the Jacobian's singular values, columns scaled to one
ASTRAY = 0.1  # of the width: so far off is no scatter but another camera
COARSE_PX = 0.5  # rms: centroids and servos are better
FAR_PX = 1e6  # residual of a ray that the lens does not see
VAGUE_FOCAL, VAGUE_CENTRE = 0.02, 0.05  # of the focal length, of the width


@dataclass(frozen=True)
class TurnCalibration:
    """
    A camera, and how it sits on its servo.

    Parameters
    ----------
    model : CameraModel
        The camera.
    values, sigmas : dict
        Each of fx, fy, cx, cy (px), k1, and azimuth and elevation of the target in the servo's
        base, yaw, pitch and roll of the camera on the servo (rad), and its standard deviation;
        0 for what was not fitted but taken as known.
    fitted : tuple of str
        Names of the parameters that were fitted; fy is not among them where it is tied to fx.
    covariance : (p, p) array
        Of those, in that order.
    residuals : (n, 2) array
        Measured less fitted, px.
    chi2 : float
        Sum of the squared residuals over their variances.
    freedom : int
        Its degrees of freedom.
    factor : float
        By which the covariance was multiplied, since the scatter said so.
    notes : tuple of str
        What the measurements could not tell, a sentence each.

    Examples
    --------
    What is fitted where the pixels are square, of 25 stations:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> true, guess = (CameraModel(640, 480, pinhole_matrix(f, 640, 480)) for f in (600.0, 500.0))
    >>> pan, tilt = (angle.ravel() for angle in np.mgrid[-0.4:0.4:5j, -0.3:0.3:5j])  # rad
    >>> pixels = project(true, pan, tilt, target=(0.02, 0.0))
    >>> pixels += np.random.default_rng(1).normal(0.0, 0.02, pixels.shape)
    >>> found = calibrate_turn(pan, tilt, pixels, guess, one_focal_length=True)
    >>> found.fitted
    ('fx', 'cx', 'cy', 'azimuth', 'elevation', 'yaw', 'pitch', 'roll')
    >>> found.freedom, len(found.residuals)
    (42, 25)

    """

    model: CameraModel
    values: dict[str, float]
    sigmas: dict[str, float]
    fitted: tuple[str, ...]
    covariance: NDArray[np.float64]
    residuals: NDArray[np.float64]
    chi2: float
    freedom: int
    factor: float
    notes: tuple[str, ...]


def project(
    model: CameraModel,
    pan: NDArray[np.float64],
    tilt: NDArray[np.float64],
    *,
    target: tuple[float, float],
    misalignment: tuple[float, float, float] = (0.0, 0.0, 0.0),
    offset: float = 0.0,
) -> NDArray[np.float64]:
    """
    Image a still target through a camera that a servo carries.

    With turns R_y to the right and R_x upwards (interface: about y and x of the optical frame),
    the camera's axes in the base are R_y(pan) R_x(tilt) R_x(pitch) R_y(yaw) R_z(roll), and the
    target, in the direction d, is seen along

        R_z' R_y(yaw)' R_x(pitch)' [R_x(tilt)' R_y(pan)' d - (0, 0, offset)]

    Parameters
    ----------
    model : CameraModel
        The camera.
    pan, tilt : (n,) arrays
        Angles of the servo, rad, positive to the right and upwards.
    target : (float, float)
        Azimuth and elevation of the target in the servo's base, rad.
    misalignment : (float, float, float)
        yaw, pitch and roll of the camera on the servo, rad.
    offset : float
        Lens in front of the crossing of the axes, over the range of the target.

    Returns
    -------
    (n, 2) array
        px; NaN where the camera does not see it.

    Examples
    --------
    A servo that turns the camera 0.1 rad to the right moves the picture of the target to the left:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> pixels = project(model, np.array([0.0, 0.1]), np.zeros(2), target=(0.0, 0.0))
    >>> pixels.round(1).tolist()  # px
    [[319.5, 239.5], [259.3, 239.5]]

    """
    azimuth, elevation = target
    yaw, pitch, roll = misalignment
    x = np.cos(elevation) * np.sin(azimuth - pan)
    y = np.full_like(x, -np.sin(elevation))
    z = np.cos(elevation) * np.cos(azimuth - pan)
    y, z = np.cos(tilt) * y + np.sin(tilt) * z, np.cos(tilt) * z - np.sin(tilt) * y
    z = z - offset
    y, z = np.cos(pitch) * y + np.sin(pitch) * z, np.cos(pitch) * z - np.sin(pitch) * y
    x, z = np.cos(yaw) * x - np.sin(yaw) * z, np.cos(yaw) * z + np.sin(yaw) * x
    x, y = np.cos(roll) * x + np.sin(roll) * y, np.cos(roll) * y - np.sin(roll) * x
    return model.project(np.stack([x, y, z], axis=1))


def calibrate_turn(
    pan: NDArray[np.float64],
    tilt: NDArray[np.float64],
    pixels: NDArray[np.float64],
    guess: CameraModel,
    *,
    pixel_sigma: NDArray[np.float64] | None = None,
    step_sigma: float = 0.0,
    one_focal_length: bool = False,
    fit_centre: bool = True,
    fit_distortion: bool = False,
    offset: float = 0.0,
) -> TurnCalibration:
    """
    Fit a camera to the pixels at which a still target is seen from the servo's positions.

    Non-linear least squares on `project`, for fx, fy, cx, cy, the direction of the target and
    the turn of the camera on the servo. The variance of a station is that of its pixel and that
    of the servo's steps, carried through the derivative J of the pixel by the two angles:

        C_i = diag(pixel_sigma_i^2) + step_sigma^2 J_i J_i'

    The signs of the axes are had from the measurements: a servo that counts to the left (as a
    turn about ROS' upward z does) or downwards is taken as it is.

    Parameters
    ----------
    pan, tilt : (n,) arrays
        Angles of the servo, rad.
    pixels : (n, 2) array
        Where the target is, px.
    guess : CameraModel
        Size, lens model and distortion, which are kept, and a first guess of the rest.
    pixel_sigma : (n, 2) array, optional
        Standard deviations of the pixels. Where it is left out they are had from the scatter, or
        are taken as nothing beside `step_sigma` where that is given.
    step_sigma : float
        Standard deviation of an angle of the servo, rad.
    one_focal_length : bool
        Square pixels: fy is fx.
    fit_centre : bool
        Fit the principal point; else it stays that of the guess.
    fit_distortion : bool
        Fit k1, the first coefficient of the lens model.
    offset : float
        How far the lens is in front of the crossing of the axes, over the range of the target.

    Returns
    -------
    TurnCalibration
        The camera with sigmas, and what could not be told.

    Raises
    ------
    TurnError
        If there are too few stations, values that are not possible, or no such servo.

    Examples
    --------
    A grid of 25 stations, at each of which the target is placed to 0.02 px:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> true, guess = (CameraModel(640, 480, pinhole_matrix(f, 640, 480)) for f in (600.0, 500.0))
    >>> pan, tilt = (angle.ravel() for angle in np.mgrid[-0.4:0.4:5j, -0.3:0.3:5j])  # rad
    >>> pixels = project(true, pan, tilt, target=(0.02, 0.0))
    >>> pixels += np.random.default_rng(1).normal(0.0, 0.02, pixels.shape)
    >>> found = calibrate_turn(pan, tilt, pixels, guess)
    >>> round(found.values['fx'], 1), round(found.sigmas['fx'], 2)  # px
    (600.0, 0.01)

    """
    pan, tilt, pixels = (np.asarray(values, dtype=float) for values in (pan, tilt, pixels))
    check_stations(pan, tilt, pixels, pixel_sigma, step_sigma, guess)
    turned = (float(np.ptp(pan)) > STILL_RAD, float(np.ptp(tilt)) > STILL_RAD)
    pan_sign, tilt_sign, focal = first_look(pan, tilt, pixels, guess, turned)
    pan, tilt = pan_sign * pan, tilt_sign * tilt
    notes = []
    if pan_sign < 0:
        notes.append('the servo counts pan to the left; it was taken so')
    if tilt_sign < 0:
        notes.append('the servo counts tilt downwards; it was taken so')
    free, about_the_axes = _told(turned, one_focal_length, fit_centre, fit_distortion)
    notes += about_the_axes
    fitted = tuple(name for name in NAMES if name in free)
    freedom = 2 * len(pan) - len(fitted)
    if freedom < 1:
        raise TurnError(
            f'{len(pan)} stations are {2 * len(pan)} numbers for {len(fitted)} unknowns; '
            f'{len(fitted) // 2 + 1} stations are the least, and 15 or more are good'
        )
    values = start_values(pan, tilt, pixels, guess, focal)

    def predicted(
        parameters: NDArray[np.float64], pan: NDArray[np.float64], tilt: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        full = values | dict(zip(fitted, parameters.tolist()))
        if 'fy' not in free:
            full['fy'] = full['fx']
        seen = project(
            _camera(guess, full), pan, tilt, target=(full['azimuth'], full['elevation']),
            misalignment=(full['yaw'], full['pitch'], full['roll']), offset=offset,
        )
        return np.where(np.isfinite(seen), seen, FAR_PX)

    def whitened(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        rest = pixels - predicted(parameters, pan, tilt)
        return np.asarray(np.einsum('nij,nj->ni', root, rest).ravel())

    solution = np.array([values[name] for name in fitted])
    for _ in range(ROUNDS if step_sigma > 0.0 else 1):
        by_servo = np.stack(
            [
                (predicted(solution, pan + a, tilt + b) - predicted(solution, pan - a, tilt - b))
                / (2.0 * STEP_RAD)
                for a, b in ((STEP_RAD, 0.0), (0.0, STEP_RAD))
            ],
            axis=2,
        )
        root = _whitening(pixels, pixel_sigma, step_sigma, by_servo)
        fit = least_squares(
            whitened, solution, method='lm', x_scale='jac', xtol=1e-12, ftol=1e-12, gtol=1e-12
        )
        solution = fit.x
    residuals = pixels - predicted(solution, pan, tilt)
    if not fit.success or np.abs(residuals).max() > ASTRAY * guess.width:
        raise TurnError(
            'no camera sees the target so: are the angles those of the servo, in their unit, and '
            'the pixels those of the same stations?'
        )
    covariance = _covariance(fit.jac, fitted)
    chi2 = float(2.0 * fit.cost)
    known = pixel_sigma is not None or step_sigma > 0.0
    factor = variance_factor(chi2, freedom, known=known)
    covariance *= factor
    values |= dict(zip(fitted, solution.tolist()))
    sigmas = dict.fromkeys(NAMES, 0.0)
    sigmas |= dict(zip(fitted, np.sqrt(np.diag(covariance)).tolist()))
    if 'fy' not in free:
        values['fy'], sigmas['fy'] = values['fx'], sigmas['fx']
    notes += _vague(values, sigmas, residuals, guess)
    return TurnCalibration(
        model=_camera(guess, values),
        values=values,
        sigmas=sigmas,
        fitted=fitted,
        covariance=covariance,
        residuals=residuals,
        chi2=chi2,
        freedom=freedom,
        factor=factor,
        notes=tuple(notes),
    )


def _told(
    turned: tuple[bool, bool], one_focal_length: bool, fit_centre: bool, fit_distortion: bool
) -> tuple[set[str], list[str]]:
    """Return the parameters that these turns tell and that are asked for, and what is to know."""
    notes = []
    free = set(NAMES) - (set() if fit_distortion else {'k1'})
    if not fit_centre:
        free -= {'cx', 'cy'}
    if one_focal_length or not all(turned):
        free -= {'fy'}
    if not turned[1]:
        # Turning about one axis only: an angle about it cannot be told from the target's own.
        free -= {'cy', 'yaw'}
        notes.append(
            'only pan was turned: fy is taken as fx, cy stays as it was, and neither was measured'
        )
    elif not turned[0]:
        free -= {'cx', 'pitch'}
        notes.append(
            'only tilt was turned: fx is taken as fy, cx stays as it was, and neither was measured'
        )
    return free, notes


def _camera(guess: CameraModel, values: dict[str, float]) -> CameraModel:
    """Return the camera of these parameters; a skew of the guess has no place among them."""
    distortion = np.array(guess.distortion, dtype=float)
    if values['k1'] != 0.0 or len(distortion):
        if not len(distortion):
            distortion = np.zeros(max(len(LENSES[guess.distortion_model].names), 1))
        distortion[0] = values['k1']
    matrix = np.array(
        [[values['fx'], 0.0, values['cx']], [0.0, values['fy'], values['cy']], [0.0, 0.0, 1.0]]
    )
    return replace(
        guess, matrix=matrix, distortion=distortion, rectification=None, projection=None
    )


def _whitening(
    pixels: NDArray[np.float64],
    pixel_sigma: NDArray[np.float64] | None,
    step_sigma: float,
    by_servo: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the (n, 2, 2) matrices that make residuals independent with unit variance."""
    if pixel_sigma is not None:
        variances = np.asarray(pixel_sigma, dtype=float) ** 2
    else:
        # 1e-4 px: only so that a station that the servo's steps cannot move is not infinite.
        variances = np.full(pixels.shape, 1e-8 if step_sigma > 0.0 else 1.0)
    covariance = variances[:, :, None] * np.eye(2)
    covariance = covariance + step_sigma**2 * by_servo @ by_servo.transpose(0, 2, 1)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def _covariance(jacobian: NDArray[np.float64], fitted: tuple[str, ...]) -> NDArray[np.float64]:
    """Return the inverse of the information, or raise with the names of what it lacks."""
    size = np.linalg.norm(jacobian, axis=0)
    if size.min() <= 0.0:
        blind = [name for name, norm in zip(fitted, size) if norm <= 0.0]
        raise TurnError(f'the stations say nothing about {", ".join(blind)}; turn further')
    _, singular, right = np.linalg.svd(jacobian / size, full_matrices=False)
    if singular[-1] < SINGULAR * singular[0]:
        mixed = [name for name, part in zip(fitted, right[-1]) if abs(part) > 0.1]
        raise TurnError(
            f'the stations cannot separate {", ".join(mixed)}: turn further, both axes, and into '
            'the corners of the picture'
        )
    inverse = (right.T / singular) / size[:, None]
    return np.asarray(inverse @ inverse.T)


def _vague(
    values: dict[str, float],
    sigmas: dict[str, float],
    residuals: NDArray[np.float64],
    guess: CameraModel,
) -> list[str]:
    """Say what the stations tell too little of."""
    notes: list[str] = []
    for name in ('fx', 'fy'):
        if sigmas[name] > VAGUE_FOCAL * values[name] and not (name == 'fy' and notes):
            notes.append(
                f'{name} is known to {sigmas[name]:.3g} px only: the steps span too little of the '
                'picture; turn further'
            )
    rms = float(np.sqrt((residuals**2).mean()))
    if rms > COARSE_PX:
        notes.append(
            f'the residuals are {rms:.1f} px rms, far above the scatter of a centroid: are the '
            'angles in the unit that their columns say, and is the distortion right?'
        )
    centre = max(sigmas['cx'], sigmas['cy'])
    if centre > VAGUE_CENTRE * guess.width:
        notes.append(
            f'the principal point is known to {centre:.3g} px only: turn further, or keep it '
            'in its place with --fix-centre'
        )
    return notes

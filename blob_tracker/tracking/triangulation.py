"""Where a light is that two or more cameras see: the point at which their rays meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations
import math

from blob_tracker.kernel import Array
from blob_tracker.tracking.errors import TrackingError
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
import scipy  # which loads its parts when they are first used

# Standard deviations of the angle between two rays: where it is less, the distance has no Gaussian
# error. At five the mean distance is 4 % too great, a fifth of its standard deviation.
PARALLAX = 5.0
ROUNDING = 1e-12  # rad: angles of less are not known to double precision
STEPS = 30
CONVERGED = 1e-3  # standard deviations of the position


class TriangulationError(TrackingError):
    """Rays that give no position; the message says why."""


class ParallelRays(TriangulationError):
    """Rays that are parallel as far as their covariances can tell."""


class RaysApart(TriangulationError):
    """Rays that meet nowhere, or behind a camera: they are not of one light."""


@dataclass(frozen=True)
class CameraPose:
    """
    Where a camera is and how it is turned, in the frame of reference.

    Parameters
    ----------
    position : (3,) array
        Of its optical centre, m.
    rotation : (3, 3) array
        Takes components in the optical frame (x right, y down, z forward) to those in the
        reference.
    position_sigma : float
        Standard deviation of the position along each axis, m.
    rotation_sigma : float
        Standard deviation of the rotation about each axis, rad.

    Raises
    ------
    ValueError
        Where one of them cannot be.

    """

    position: Array
    rotation: Array = field(default_factory=lambda: np.eye(3))
    position_sigma: float = 0.0
    rotation_sigma: float = 0.0

    def __post_init__(self) -> None:
        if np.shape(self.position) != (3,) or not np.isfinite(self.position).all():
            raise ValueError(f'the position {self.position} must be 3 finite numbers')
        if np.shape(self.rotation) != (3, 3) or not (
            np.allclose(self.rotation @ self.rotation.T, np.eye(3), atol=1e-6)
            and np.linalg.det(self.rotation) > 0.0
        ):
            raise ValueError('the rotation must be a (3, 3) matrix that turns and does no more')
        for name in ('position_sigma', 'rotation_sigma'):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise ValueError(f'{name} is {getattr(self, name)}; it must be finite, 0 or more')


@dataclass(frozen=True)
class Position:
    """
    Where a light is.

    Parameters
    ----------
    position : (3,) array
        In the frame of reference, m.
    covariance : (3, 3) array
        m^2; from the bearings and the camera poses.
    systematic : (3, 3) array
        The part of it that the camera poses make, m^2. It is the same error in each position of
        the same cameras and does not average out over time.
    chi2 : float
        Squared residuals over their variance: how well the rays meet.
    degrees_of_freedom : int
        Mean of `chi2` where they do: two for each ray, less three.
    stamp_ns : int
        That of the first bearing, ns of ROS time.

    """

    position: Array
    covariance: Array
    systematic: Array
    chi2: float
    degrees_of_freedom: int
    stamp_ns: int = 0


def triangulate(
    bearings: Sequence[Bearing], poses: Sequence[CameraPose], *, gate: float = 5.0
) -> Position:
    """
    Return where the rays of one light meet: the position of maximum likelihood.

    Camera i at c_i, turned by R_i, sees the position X as p = R_i^T (X - c_i) at the angles

        h_i(X) = (atan2(p_x, p_z), atan2(-p_y, hypot(p_x, p_z)))

    and X minimises the squared residuals of all cameras over their covariance,

        chi2 = sum_i r_i^T S_i^-1 r_i,    r_i = z_i - h_i(X)

    (Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 12.3, eq. 12.1, with angles in
    place of pixels), by Gauss-Newton steps from the point that is nearest to all rays, the
    solution of sum_i (I - d_i d_i^T)(X - c_i) = 0 with the directions d_i (the midpoint of two
    rays; Hartley & Sturm, Triangulation, CVIU 68 (1997), section 5.3). With J_i = dh_i/dX,

        covariance = (sum_i J_i^T S_i^-1 J_i)^-1

    is the inverse of the Fisher information. S_i is the bearing's covariance and what the errors
    of the camera's pose do to its angles,

        S_i = C_i + E_i,    E_i = sigma_p^2 J_i J_i^T + sigma_r^2 A_i [p]x [p]x^T A_i^T

    with A_i = dh_i/dp. Errors of the poses are taken as independent from camera to camera. They
    weigh as those of the bearings do in a single position, but from one position to the next they
    stay: `systematic` is their part of the covariance, sum_i G_i E_i G_i^T with
    G_i = covariance J_i^T S_i^-1.

    Parameters
    ----------
    bearings : sequence of Bearing
        One of each camera, at one instant, each in its camera's optical frame.
    poses : sequence of CameraPose
        Of the cameras, in the same order.
    gate : float
        How far apart rays may pass that are said to meet, in standard deviations: chi2 may be as
        improbable as a Gaussian deviate beyond +-gate.

    Returns
    -------
    Position
        With its covariance.

    Raises
    ------
    ParallelRays
        Where no two rays differ by more than five standard deviations of the angle between them.
    RaysApart
        Where the rays do not meet within the gate, or meet behind a camera.
    TriangulationError
        Where there are fewer than two bearings, or one or its covariance is not finite, or the
        covariance is not positive definite.

    """
    if len(bearings) != len(poses) or len(bearings) < 2:
        raise TriangulationError(
            f'{len(bearings)} bearings of {len(poses)} cameras; there must be two or more, and as '
            'many'
        )
    for bearing in bearings:
        check_bearing(bearing)
    seen = MRAD * np.array([[each.azimuth, each.elevation] for each in bearings])
    noise = MRAD**2 * np.array([each.covariance for each in bearings])
    directions = np.array(
        [pose.rotation @ _direction(*angles) for pose, angles in zip(poses, seen, strict=True)]
    )
    _check_parallax(seen, noise, directions, poses)
    position = _nearest(directions, np.array([pose.position for pose in poses]))
    for _ in range(STEPS):
        _check_ahead(position, directions, poses)
        residuals, jacobians, errors = _linearised(position, seen, poses)
        weights = np.linalg.inv(noise + errors)
        information = np.einsum('iab,iac,icd->bd', jacobians, weights, jacobians)
        step = np.linalg.solve(
            information, np.einsum('iab,iac,ic->b', jacobians, weights, residuals)
        )
        position = position + step
        if step @ information @ step < CONVERGED**2:
            break
    else:
        raise RaysApart(f'the rays meet nowhere: no position was found in {STEPS} steps')
    _check_ahead(position, directions, poses)
    chi2 = float(np.einsum('ia,iab,ib->', residuals, weights, residuals) - step @ (
        information @ step
    ))
    degrees = 2 * len(bearings) - 3
    most = _most(gate, degrees)
    if chi2 > most:
        raise RaysApart(
            f'the rays do not meet: chi-square is {chi2:.1f} and may be {most:.1f} (gate '
            f'{gate:g}); they are of different lights or instants, or a camera is not where its '
            'pose says'
        )
    covariance = np.linalg.inv(information)
    gains = covariance @ np.swapaxes(jacobians, 1, 2) @ weights
    return Position(
        position=position,
        covariance=covariance,
        systematic=np.einsum('iab,ibc,idc->ad', gains, errors, gains),
        chi2=max(chi2, 0.0),
        degrees_of_freedom=degrees,
        stamp_ns=bearings[0].stamp_ns,
    )


def check_bearing(bearing: Bearing) -> None:
    """Raise TriangulationError where a bearing or its covariance can be that of no ray."""
    covariance = bearing.covariance
    if not (
        math.isfinite(bearing.azimuth)
        and math.isfinite(bearing.elevation)
        and np.isfinite(covariance).all()
    ):
        raise TriangulationError(
            f'the bearing is ({bearing.azimuth}, {bearing.elevation}) mrad with the covariance '
            f'{np.asarray(covariance).tolist()} mrad^2; all must be finite'
        )
    if not (
        covariance[0, 0] > 0.0
        and np.linalg.det(covariance) > 0.0
        and np.allclose(covariance, covariance.T, rtol=1e-6, atol=0.0)
    ):
        raise TriangulationError(
            f'the covariance of the bearing is {np.asarray(covariance).tolist()} mrad^2; it must '
            'be symmetric and positive definite: no camera sees without error'
        )


def _direction(azimuth: float, elevation: float) -> Array:
    """Return the unit vector of the optical frame in a direction, rad."""
    level = math.cos(elevation)
    return np.array(
        [level * math.sin(azimuth), -math.sin(elevation), level * math.cos(azimuth)]
    )


def _tangents(azimuth: float, elevation: float) -> Array:
    """Return the (3, 2) derivative of the direction by both angles."""
    sine, cosine = math.sin(azimuth), math.cos(azimuth)
    return np.array([
        [math.cos(elevation) * cosine, -math.sin(elevation) * sine],
        [0.0, -math.cos(elevation)],
        [-math.cos(elevation) * sine, -math.sin(elevation) * cosine],
    ])


def _check_parallax(
    seen: Array, noise: Array, directions: Array, poses: Sequence[CameraPose]
) -> None:
    """Refuse rays of which no two differ in direction by more than their errors."""
    best, angle = 0.0, 0.0
    for one, other in combinations(range(len(poses)), 2):
        across = np.cross(directions[one], directions[other])
        sine = float(np.linalg.norm(across))
        if sine < ROUNDING:
            continue
        variance = 0.0
        for index in (one, other):
            # How the ray turns about the common perpendicular of both.
            pose = poses[index]
            aside = pose.rotation.T @ np.cross(across / sine, directions[index])
            turn = aside @ _tangents(*seen[index])
            variance += float(turn @ noise[index] @ turn) + pose.rotation_sigma**2
        if sine > best * math.sqrt(variance):
            best, angle = sine / math.sqrt(variance), math.asin(min(sine, 1.0))
    if best < PARALLAX:
        raise ParallelRays(
            f'the rays are parallel: they differ by {angle / MRAD:.3g} mrad, {best:.1f} times '
            f'the standard deviation of that angle, and must by {PARALLAX:g} times; the light is '
            'too far away for the distance of the cameras, or in line with them'
        )


def _nearest(directions: Array, centres: Array) -> Array:
    """Return the point with the least squared distance from all rays."""
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    return np.linalg.solve(across.sum(axis=0), np.einsum('iab,ib->a', across, centres))


def _check_ahead(position: Array, directions: Array, poses: Sequence[CameraPose]) -> None:
    """Refuse a position that lies behind a camera, seen along its ray."""
    for number, (direction, pose) in enumerate(zip(directions, poses, strict=True), 1):
        if not direction @ (position - pose.position) > 0.0:  # nor NaN
            raise RaysApart(
                f'the rays meet behind camera {number}: they are of different lights, or a camera '
                'is not where its pose says'
            )


def _linearised(
    position: Array, seen: Array, poses: Sequence[CameraPose]
) -> tuple[Array, Array, Array]:
    """
    Return what each camera sees of a position.

    Returns
    -------
    (n, 2) array, (n, 2, 3) array, (n, 2, 2) array
        Residuals, rad, their derivative J by the position, rad/m, less its sign, and the
        covariance E of the angles by the errors of the pose, rad^2.

    """
    residuals, jacobians, errors = [], [], []
    for angles, pose in zip(seen, poses, strict=True):
        x, y, z = pose.rotation.T @ (position - pose.position)
        level = math.hypot(x, z)
        square = level**2 + y**2
        by_local = np.array([
            [z / level**2, 0.0, -x / level**2],
            [x * y / (level * square), -level / square, z * y / (level * square)],
        ])
        jacobian = by_local @ pose.rotation.T
        # [p]x, the derivative of the local position by a turn of the camera.
        turned = by_local @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        residual = angles - (math.atan2(x, z), math.atan2(-y, level))
        residual[0] = math.remainder(residual[0], math.tau)
        residuals.append(residual)
        jacobians.append(jacobian)
        errors.append(
            pose.position_sigma**2 * jacobian @ jacobian.T
            + pose.rotation_sigma**2 * turned @ turned.T
        )
    return np.array(residuals), np.array(jacobians), np.array(errors)


@cache
def _most(gate: float, degrees: int) -> float:
    """Return the chi-square that is as improbable as a Gaussian deviate beyond +-gate."""
    return float(scipy.stats.chi2.isf(math.erfc(gate / math.sqrt(2.0)), degrees))

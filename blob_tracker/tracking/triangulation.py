"""Where a light is that two or more cameras see: the point at which their rays meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations
import math
from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.camera_pose import CameraPose
from blob_tracker.tracking.errors import ParallelRays, RaysApart, TriangulationError
from blob_tracker.tracking.rays import direction, linearised, nearest_point, tangents
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
import scipy  # which loads its parts when they are first used

# Standard deviations of the angle between two rays: where it is less, the distance has no Gaussian
# error. At five the mean distance is 4 % too great, a fifth of its standard deviation.
PARALLAX_SIGMA = 5.0
ROUNDING_RAD = 1e-12  # angles of less are not known to double precision
STEPS = 30
CONVERGED_SIGMA = 1e-3  # of the position


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
    bearings: Sequence[Bearing], poses: Sequence[CameraPose], *, gate_sigma: float = 5.0
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
    gate_sigma : float
        How far apart rays may pass that are said to meet, in standard deviations: chi2 may be as
        improbable as a Gaussian deviate beyond +-gate_sigma.

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
        [pose.rotation @ direction(*angles) for pose, angles in zip(poses, seen, strict=True)]
    )
    _check_parallax(seen, noise, directions, poses)
    fit = _fitted(seen, noise, directions, poses)
    degrees = 2 * len(bearings) - 3
    most = _most(gate_sigma, degrees)
    if fit.chi2 > most:
        raise RaysApart(
            f'the rays do not meet: chi-square is {fit.chi2:.1f} and may be {most:.1f} (gate '
            f'{gate_sigma:g}); they are of different lights or instants, or a camera is not where '
            'its pose says'
        )
    return Position(
        position=fit.position,
        covariance=fit.covariance,
        systematic=fit.systematic,
        chi2=max(fit.chi2, 0.0),
        degrees_of_freedom=degrees,
        stamp_ns=bearings[0].stamp_ns,
    )


class _Fit(NamedTuple):
    """The position of maximum likelihood, m, its covariances, m^2, and chi-square."""

    position: Array
    covariance: Array
    systematic: Array
    chi2: float


def _fitted(
    seen: Array, noise: Array, directions: Array, poses: Sequence[CameraPose]
) -> _Fit:
    """Return the fit by Gauss-Newton steps from the point that is nearest to all rays."""
    position = nearest_point(directions, np.array([pose.position for pose in poses]))
    for _ in range(STEPS):
        _check_ahead(position, directions, poses)
        residuals, jacobians, errors = linearised(position, seen, poses)
        weights = np.linalg.inv(noise + errors)
        information = np.einsum('iab,iac,icd->bd', jacobians, weights, jacobians)
        step = np.linalg.solve(
            information, np.einsum('iab,iac,ic->b', jacobians, weights, residuals)
        )
        position = position + step
        if step @ information @ step < CONVERGED_SIGMA**2:
            break
    else:
        raise RaysApart(f'the rays meet nowhere: no position was found in {STEPS} steps')
    _check_ahead(position, directions, poses)
    chi2 = float(np.einsum('ia,iab,ib->', residuals, weights, residuals) - step @ (
        information @ step
    ))
    covariance = np.linalg.inv(information)
    gains = covariance @ np.swapaxes(jacobians, 1, 2) @ weights
    return _Fit(position, covariance, np.einsum('iab,ibc,idc->ad', gains, errors, gains), chi2)


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


def _check_parallax(
    seen: Array, noise: Array, directions: Array, poses: Sequence[CameraPose]
) -> None:
    """Refuse rays of which no two differ in direction by more than their errors."""
    best, angle = 0.0, 0.0
    for one, other in combinations(range(len(poses)), 2):
        across = np.cross(directions[one], directions[other])
        sine = float(np.linalg.norm(across))
        if sine < ROUNDING_RAD:
            continue
        variance = 0.0
        for index in (one, other):
            # How the ray turns about the common perpendicular of both.
            pose = poses[index]
            aside = pose.rotation.T @ np.cross(across / sine, directions[index])
            turn = aside @ tangents(*seen[index])
            variance += float(turn @ noise[index] @ turn) + pose.rotation_sigma**2
        if sine > best * math.sqrt(variance):
            best, angle = sine / math.sqrt(variance), math.asin(min(sine, 1.0))
    if best < PARALLAX_SIGMA:
        raise ParallelRays(
            f'the rays are parallel: they differ by {angle / MRAD:.3g} mrad, {best:.1f} times the '
            f'standard deviation of that angle, and must by {PARALLAX_SIGMA:g} times; the light '
            'is too far away for the distance of the cameras, or in line with them'
        )


def _check_ahead(position: Array, directions: Array, poses: Sequence[CameraPose]) -> None:
    """Refuse a position that lies behind a camera, seen along its ray."""
    for number, (ray, pose) in enumerate(zip(directions, poses, strict=True), 1):
        if not ray @ (position - pose.position) > 0.0:  # nor NaN
            raise RaysApart(
                f'the rays meet behind camera {number}: they are of different lights, or a camera '
                'is not where its pose says'
            )


@cache
def _most(gate_sigma: float, degrees: int) -> float:
    """Return the chi-square that is as improbable as a Gaussian deviate beyond +-gate_sigma."""
    return float(scipy.stats.chi2.isf(math.erfc(gate_sigma / math.sqrt(2.0)), degrees))

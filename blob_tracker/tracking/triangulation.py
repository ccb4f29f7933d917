"""Where a light is that two or more cameras see: the point at which their rays meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
import math
from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.camera_pose import CameraPose
from blob_tracker.tracking.errors import ParallelRays, RaysApart, TriangulationError
from blob_tracker.tracking.rays import linearised, nearest_point, Rays, tangents
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np

# Standard deviations of the angle between two rays: where it is less, the distance has no Gaussian
# error. At five the mean distance is 4 % too great, a fifth of its standard deviation.
PARALLAX_SIGMA = 5.0
ROUNDING_RAD = 1e-12  # angles of less are not known to double precision
STEPS = 30
CONVERGED_SIGMA = 1e-3  # of the position
# Of chi-square: which rays are of another light is told if it is a thousand times as likely as
# any other answer with as many, 2 ln 1000.
TOLD = 13.8


class Outlier(NamedTuple):
    """A ray that passes the others by: which, and by how many standard deviations."""

    name: str
    sigmas: float


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
    outliers : tuple of Outlier
        The rays that are of something else, and not used.

    Examples
    --------
    Its standard deviations, and whether the rays meet:

    >>> light = Position(
    ...     np.array([0.5, 0.0, 10.0]), np.diag([5e-7, 5e-7, 2e-4]), np.zeros((3, 3)),
    ...     chi2=0.8, degrees_of_freedom=1,
    ... )
    >>> np.sqrt(light.covariance.diagonal()).round(4).tolist()  # m
    [0.0007, 0.0007, 0.0141]

    """

    position: Array
    covariance: Array
    systematic: Array
    chi2: float
    degrees_of_freedom: int
    stamp_ns: int = 0
    outliers: tuple[Outlier, ...] = ()


def triangulate(
    bearings: Sequence[Bearing],
    poses: Sequence[CameraPose],
    *,
    gate_sigma: float = 5.0,
    shared: Array | None = None,
    strayed: Array | None = None,
    names: Sequence[str] = (),
) -> Position:
    """
    Return where the rays of one light meet: the position of maximum likelihood.

    Camera i at c_i, turned by R_i, sees the position X as p = R_i^T (X - c_i) at the angles

        h_i(X) = (atan2(p_x, p_z), atan2(-p_y, hypot(p_x, p_z)))

    and X minimises the squared residuals of all cameras over their covariance,

        chi2 = r^T S^-1 r,    r_i = z_i - h_i(X)

    (Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 12.3, eq. 12.1, with angles in
    place of pixels), by Gauss-Newton steps from the point that is nearest to all rays, the
    solution of sum_i (I - d_i d_i^T)(X - c_i) = 0 with the directions d_i (the midpoint of two
    rays; Hartley & Sturm, Triangulation, CVIU 68 (1997), section 5.3). With J_i = dh_i/dX,

        covariance = (J^T S^-1 J)^-1

    is the inverse of the Fisher information. The covariance of all angles together, S, is that of
    the bearings and what the errors of the poses do to them,

        S = C + E + D,    E = P Q P^T,    P_i = A_i ([p]x, -R_i^T)
        D_ij = V_ij d_i d_j J_i J_j^T

    with A_i = dh_i/dp, the covariance Q of the cameras' turns and positions, and that of what the
    light strays between two rays, V, at the distances d_i. The errors of the
    poses weigh as those of the bearings do in a single position, but from one position to the
    next they stay: `systematic` is their part of the covariance, G E G^T with
    G = covariance J^T S^-1.

    Of three rays or more that do not meet, as few as possible are left out, and fewer than the
    rest, so that the rest meet: the choice of least chi2, which must be a thousand times as likely
    as the next one with as many. Nothing is left out where it is not: then no position is right.

    Parameters
    ----------
    bearings : sequence of Bearing
        One of each camera, at one instant, each in its camera's optical frame.
    poses : sequence of CameraPose
        Of the cameras, in the same order.
    gate_sigma : float
        How far apart rays may pass that are said to meet, in standard deviations: chi2 may be as
        improbable as a Gaussian deviate beyond +-gate_sigma.
    shared : (6 n, 6 n) array, optional
        What the cameras' poses err by in common, besides their own sigmas: the covariance of each
        camera's turn about its own axes, rad, and its position, m, in this order.
    strayed : (n, n) array, optional
        V, rad^2, of bearings that were interpolated, see `Instant`.
    names : sequence of str
        Of the cameras, for what is said of them; their numbers if there are none.

    Returns
    -------
    Position
        With its covariance.

    Raises
    ------
    ParallelRays
        If no two rays differ by more than five standard deviations of the angle between them.
    RaysApart
        If the rays do not meet within the gate, or meet behind a camera, and it is not told
        which of them are of another light.
    TriangulationError
        If there are fewer than two bearings, or one or its covariance is not finite, or the
        covariance is not positive definite.

    Examples
    --------
    Two cameras, 1 m apart, that look straight ahead at a light 10 m away between them; both see it
    0.05 rad off their axes, to 0.1 mrad:

    >>> poses = [CameraPose(np.zeros(3)), CameraPose(np.array([1.0, 0.0, 0.0]))]
    >>> angle = 1e3 * np.arctan2(0.5, 10.0)
    >>> bearings = [Bearing(sign * angle, 0.0, 0.01 * np.eye(2)) for sign in (1.0, -1.0)]
    >>> light = triangulate(bearings, poses)
    >>> light.position[::2].round(3).tolist()  # x and z, m
    [0.5, 10.0]
    >>> np.sqrt(light.covariance.diagonal()).round(4).tolist()  # m
    [0.0007, 0.0007, 0.0142]

    """
    if len(bearings) != len(poses) or len(bearings) < 2:
        raise TriangulationError(
            f'bearings: {len(bearings)}, cameras: {len(poses)}; there must be two or more, and as '
            'many of each'
        )
    for bearing in bearings:
        check_bearing(bearing)
    names = names or [f'camera {number}' for number in range(1, len(poses) + 1)]
    rays = Rays.of(bearings, poses, shared, strayed)
    parallax = _parallax(rays)
    try:
        _check_parallax(parallax)
        position = _met(rays, names, gate_sigma)
    except RaysApart:
        if len(bearings) == 2:
            raise
        position = _without_outliers(rays, names, gate_sigma, parallax)
    return replace(position, stamp_ns=bearings[0].stamp_ns)


def _without_outliers(
    rays: Rays, names: Sequence[str], gate_sigma: float, parallax: tuple[Array, Array]
) -> Position:
    """Return where the rays meet if those that pass the others by are left out."""
    count = len(names)
    for number in range(1, (count + 1) // 2):
        found: list[tuple[float, tuple[int, ...], Position | ParallelRays]] = []
        for left_out in combinations(range(count), number):
            rest = [each for each in range(count) if each not in left_out]
            of_rest = [names[each] for each in rest]
            try:
                angles, ratios = (each[np.ix_(rest, rest)] for each in parallax)
                _check_parallax((angles, ratios))
                position = _met(rays.some(rest), of_rest, gate_sigma)
                found.append((position.chi2, left_out, position))
            except ParallelRays as error:  # they may meet, and nothing speaks for others
                found.append((0.0, left_out, error))
            except RaysApart:
                continue
        if not found:
            continue
        found.sort(key=lambda each: each[0])
        best, left_out, answer = found[0]
        if len(found) > 1 and found[1][0] - best < TOLD:
            raise RaysApart(
                'the rays do not meet, and which one is of another light is unknown: the others '
                'agree without ' + ', or without '.join(
                    ' and '.join(names[each] for each in which)
                    for chi2, which, _ in found if chi2 - best < TOLD
                )
            )
        if isinstance(answer, ParallelRays):
            raise answer
        return replace(answer, outliers=tuple(
            Outlier(names[each], _away(rays.some([each]), answer)) for each in left_out
        ))
    raise RaysApart(
        f'no more than half of the rays of {", ".join(names)} meet: they are of different lights '
        'or instants, or the cameras are not where their poses say'
    )


def _away(ray: Rays, position: Position) -> float:
    """Return how many standard deviations one ray is away from a position."""
    residual, jacobian, errors, strayed = linearised(position.position, ray)
    spread = ray.noise[0] + errors + strayed + jacobian @ position.covariance @ jacobian.T
    return math.sqrt(float(residual @ np.linalg.solve(spread, residual)))


def _met(rays: Rays, names: Sequence[str], gate_sigma: float) -> Position:
    """
    Return where all rays meet, by Gauss-Newton steps from the point that is nearest to them.

    Raises RaysApart where they do not.
    """
    import scipy  # no part of a start

    position = nearest_point(rays)
    noise = scipy.linalg.block_diag(*rays.noise)
    for _ in range(STEPS):
        _check_ahead(position, rays, names)
        residuals, jacobian, errors, strayed = linearised(position, rays)
        weights = np.linalg.inv(noise + errors + strayed)
        weighted = jacobian.T @ weights
        information = weighted @ jacobian
        step = np.linalg.solve(information, weighted @ residuals)
        position = position + step
        gained = step @ information @ step
        if gained < CONVERGED_SIGMA**2:
            break
    else:
        raise RaysApart(f'the rays meet nowhere: no position was found in {STEPS} steps')
    _check_ahead(position, rays, names)
    chi2 = max(float(residuals @ weights @ residuals - gained), 0.0)
    degrees = 2 * len(names) - 3
    most = _most(gate_sigma, degrees)
    if chi2 > most:
        raise RaysApart(
            f'the rays of {", ".join(names)} do not meet: chi-square is {chi2:.1f} and may be '
            f'{most:.1f} (gate {gate_sigma:g}); they are of different lights or instants, or a '
            'camera is not where its pose says'
        )
    covariance = np.linalg.inv(information)
    gains = covariance @ weighted
    return Position(position, covariance, gains @ errors @ gains.T, chi2, degrees)


def load_ahead() -> None:
    """Have SciPy load the parts for which a first position would wait, by making one."""
    poses = [CameraPose(np.array([x, 0.0, 0.0])) for x in (-1.0, 1.0)]
    triangulate([Bearing(azimuth, 0.0, np.eye(2)) for azimuth in (100.0, -100.0)], poses)


def check_bearing(bearing: Bearing) -> None:
    """Raise TriangulationError if a bearing or its covariance can be that of no ray."""
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


def _parallax(rays: Rays) -> tuple[Array, Array]:
    """Return the angles between all rays, (n, n), rad, and those over their deviations."""
    one, other = rays.directions[:, None], rays.directions[None]
    across = np.cross(one, other)
    sines = np.linalg.norm(across, axis=2)
    known = sines >= ROUNDING_RAD
    across = across / np.where(known, sines, 1.0)[:, :, None]
    # How each ray turns about the common perpendicular of both, and each camera.
    aside = np.einsum('iba,ijb->ija', rays.rotations, np.cross(across, one))
    by_angles = aside @ tangents(rays.seen)
    by_turns = np.einsum('iba,ijb->ija', rays.rotations, across)
    of_turns = rays.of_poses[:, :, :3, :3]
    numbers = np.arange(len(sines))
    variances = (
        rays.strayed.diagonal()[:, None]
        + np.einsum('ija,iab,ijb->ij', by_angles, rays.noise, by_angles)
        + np.einsum('ija,iab,ijb->ij', by_turns, of_turns[numbers, numbers], by_turns)
        # The perpendicular of the other two is the opposite one.
        + np.einsum('ija,ijab,jib->ij', by_turns, of_turns, by_turns)
    )
    deviations = np.sqrt(np.where(known, variances + variances.T, 1.0))
    return np.arcsin(np.minimum(sines, 1.0)), np.where(known, sines / deviations, 0.0)


def _check_parallax(parallax: tuple[Array, Array]) -> None:
    """Refuse rays of which no two differ in direction by more than their errors."""
    angles, ratios = parallax
    best = float(ratios.max())
    if best < PARALLAX_SIGMA:
        angle = float(angles.flat[ratios.argmax()])
        raise ParallelRays(
            f'the rays are parallel: they differ by {angle / MRAD:.3g} mrad, {best:.1f} times the '
            f'standard deviation of that angle, and must by {PARALLAX_SIGMA:g} times; the light '
            'is too far away for the distance of the cameras, or in line with them'
        )


def _check_ahead(position: Array, rays: Rays, names: Sequence[str]) -> None:
    """Refuse a position that lies behind a camera, seen along its ray."""
    along = (rays.directions * (position - rays.centres)).sum(axis=1)
    behind = np.flatnonzero(~(along > 0.0))  # nor NaN
    if len(behind):
        raise RaysApart(
            f'the rays of {", ".join(names)} meet behind {names[behind[0]]}: they are of '
            'different lights, or a camera is not where its pose says'
        )


@cache
def _most(gate_sigma: float, degrees: int) -> float:
    """Return the chi-square that is as improbable as a Gaussian deviate beyond +-gate_sigma."""
    import scipy

    return float(scipy.special.chdtri(degrees, math.erfc(gate_sigma / math.sqrt(2.0))))

"""How a camera sits on a pan/tilt, from turning it before a light that stands still."""

from __future__ import annotations

from dataclasses import dataclass
import math

from blob_tracker.calibration.rays import Rays
from blob_tracker.calibration.scatter import variance_factor
from blob_tracker.tracking.rays import angles_of, by_place_of
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

NAMES = (
    'pan_axis_1', 'pan_axis_2', 'tilt_axis_1', 'tilt_axis_2', 'pan_arm_1', 'pan_arm_2',
    'tilt_arm_1', 'tilt_arm_2', 'light_1', 'light_2', 'clock',
)
AXES, ARMS, LIGHT, CLOCK = slice(0, 4), slice(4, 8), slice(8, 10), 10
FEWEST = 40  # rays, for 11 unknown
LONGEST_S = 0.25  # between two angles of a joint: what it does meanwhile is not known
LEAST_TURN = 0.05  # rad, of each joint
GATE = 25.0  # chi-square of a ray, 4 in a million if it is one of the light
ROUNDS = 5  # of leaving out strays
MOST_LEFT_OUT = 0.2  # of the rays: with more, it is not the light that is odd
MOST_FACTOR = 25.0  # chi-square per degree: beyond it the sigmas say nothing of what is wrong
SQUARE_RAD = 0.35  # by which the axes may be off a right angle, and off x and y of the camera
VAGUE_RAD = 0.02  # of an axis


class HandEyeError(ValueError):
    """Rays and angles from which no axes can be told; the message says what is missing."""


@dataclass(frozen=True)
class HandEyeCalibration:
    """
    A camera on a pan/tilt.

    Parameters
    ----------
    pan_axis, tilt_axis : (3,) arrays
        Unit vectors about which growing angles turn the camera, right-handed, in the optical
        frame at both angles 0.
    pan_arm, tilt_arm : (3,) arrays
        From the optical centre to the nearest point of each axis, in that frame; m, or in units
        of the light's range where none is given.
    light : (3,) array
        Unit vector onto the light in that frame.
    clock : float
        How late the stamps of the rays are, by those of the angles, s.
    covariance : (11, 11) array
        Of the tilts of both axes (rad, across them), of both arms (across their axes), of the
        light (rad) and the clock.
    is_metric : bool
        Whether the arms are in metres.
    used, left_out : int
        Rays.
    chi2 : float
        Squared residuals over their variances.
    freedom : int
        Its degrees of freedom.
    factor : float
        By which the covariance was multiplied, since the scatter said so.
    residuals : (n, 2) array
        Of each ray that is used, over their standard deviations.
    angles : (n, 2) array
        Pan and tilt at these, rad.

    """

    pan_axis: Array
    tilt_axis: Array
    pan_arm: Array
    tilt_arm: Array
    light: Array
    clock: float
    covariance: Array
    is_metric: bool
    used: int
    left_out: int
    chi2: float
    freedom: int
    factor: float
    residuals: Array
    angles: Array

    @property
    def sigmas(self) -> dict[str, float]:
        """Return the standard deviations by the names of `NAMES`."""
        return dict(zip(NAMES, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))


@dataclass(frozen=True)
class Joint:
    """
    Angles of a joint.

    Parameters
    ----------
    times : (m,) array
        Their stamps, s, ascending.
    angles : (m,) array
        rad.

    """

    times: Array
    angles: Array


def calibrate_hand_eye(
    rays: Rays,
    pan: Joint,
    tilt: Joint,
    *,
    joint_sigma: float = 0.0,
    distance: tuple[float, float] | None = None,
    most_offset: float = 0.1,
) -> HandEyeCalibration:
    """
    Find the axes of a pan/tilt in the frame of the camera that it carries.

    With the axes a and b and points p and q on them, in the optical frame at both angles 0, a
    light at X of that frame is at

        Rot(-tilt b) [Rot(-pan a) (X - p) + p - q] + q

    of the optical frame at other angles (a product of exponentials: Murray, Li & Sastry, A
    Mathematical Introduction to Robotic Manipulation, 1994, section 3.2). Axes, the parts of p
    and q across them, the direction of X and the offset of the clocks are those of least squares.
    All lengths are over the range of the light: rays tell no scale. Angles are interpolated by
    cubic splines; their errors weigh as the camera sees them.

    Parameters
    ----------
    rays : Rays
        To a light that stands still.
    pan, tilt : Joint
        Angles; tilt is on top of pan.
    joint_sigma : float
        Standard deviation of an angle, rad.
    distance : (float, float), optional
        Range of the light from the camera at both angles 0, m, and the standard deviation of that.
    most_offset : float
        Greatest offset of the clocks that is looked for, s.

    Raises
    ------
    HandEyeError
        If the joints turned too little or together only, the rays are not those of a light
        that stands still before such a pan/tilt, or a value is invalid.

    """
    _check(rays, pan, tilt, joint_sigma, distance)
    splines = CubicSpline(pan.times, pan.angles), CubicSpline(tilt.times, tilt.angles)
    near = np.ones(len(rays.times), dtype=bool)
    for joint in (pan, tilt):
        after = np.searchsorted(joint.times, rays.times).clip(1, len(joint.times) - 1)
        near &= joint.times[after] - joint.times[after - 1] <= LONGEST_S
        near &= (rays.times > joint.times[0] + most_offset) & (
            rays.times < joint.times[-1] - most_offset)
    rays = rays.part(near)
    if len(rays.times) < FEWEST:
        raise HandEyeError(
            f'{len(rays.times)} rays have angles of both joints within {LONGEST_S:g} s before '
            f'and after; {FEWEST} are the least: are the stamps of one clock?'
        )
    turned = [float(np.ptp(spline(rays.times))) for spline in splines]
    for name, turn in zip(('pan', 'tilt'), turned, strict=True):
        if turn < LEAST_TURN:
            raise HandEyeError(
                f'{name} turned by {math.degrees(turn):.1f} degrees while the light was seen; '
                'turn each joint through as much of the picture as there is'
            )
    problem = _Problem(rays, splines, joint_sigma)
    fit = problem.started()
    kept = np.ones(len(rays.times), dtype=bool)
    for _ in range(ROUNDS):
        fit = problem.fitted(fit, kept)
        scale = max(float(np.median(problem.chi2(fit))) / 1.386, 1.0)
        before, kept = kept, problem.chi2(fit) <= GATE * scale
        if (kept == before).all():
            break
    left_out = int((~kept).sum())
    if left_out > MOST_LEFT_OUT * len(kept):
        raise HandEyeError(
            f'{left_out} of {len(kept)} rays are elsewhere than the joints turn them: the light '
            'moved, it is another one, or pan and tilt are exchanged'
        )
    return _judged(problem, fit, kept, distance, most_offset)


class _Problem:
    """The residuals of rays to a light that stands still."""

    def __init__(
        self, rays: Rays, splines: tuple[CubicSpline, CubicSpline], joint_sigma: float
    ) -> None:
        self.rays, self._splines, self._joint_sigma = rays, splines, joint_sigma
        self.frame = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

    def turns(self, clock: float) -> Array:
        """Return pan and tilt at the rays, (n, 2)."""
        return np.stack([spline(self.rays.times - clock) for spline in self._splines], axis=1)

    def seen(self, values: Array, turns: Array) -> Array:
        """Return where the light is in the optical frame at each ray, (n, 3)."""
        (a, a_across), (b, b_across), (light, _) = self.axes(values)
        p, q = values[4:6] @ a_across, values[6:8] @ b_across
        local = Rotation.from_rotvec(-turns[:, :1] * a).apply(light - p) + p - q
        return np.asarray(Rotation.from_rotvec(-turns[:, 1:] * b).apply(local) + q)

    def axes(self, values: Array) -> list[tuple[Array, Array]]:
        """Return pan axis, tilt axis and light, each with what is across, (2, 3)."""
        found = []
        for start, two in zip(self.frame, (values[0:2], values[2:4], values[LIGHT])):
            across = np.linalg.svd(start[None])[2][1:]
            turn = Rotation.from_rotvec(np.cross(start, two @ across))
            found.append((turn.apply(start), turn.apply(across)))
        return found

    def roots(self, values: Array) -> Array:
        """Return what makes residuals independent with unit variance, (n, 2, 2)."""
        covariance = self.rays.covariance
        if self._joint_sigma > 0.0:
            turns = self.turns(values[CLOCK])
            slopes = by_place_of(self.seen(values, turns))
            for axis in np.eye(2):
                moved = self.seen(values, turns + 1e-6 * axis) - self.seen(
                    values, turns - 1e-6 * axis)
                by_joint = np.einsum('nij,nj->ni', slopes, moved) / 2e-6
                covariance = covariance + self._joint_sigma**2 * (
                    by_joint[:, :, None] * by_joint[:, None, :])
        return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))

    def residuals(self, values: Array, roots: Array) -> Array:
        """Return (n, 2) residuals over their standard deviations."""
        rest = self.rays.angles - angles_of(self.seen(values, self.turns(values[CLOCK])))
        rest[:, 0] = np.remainder(rest[:, 0] + np.pi, 2.0 * np.pi) - np.pi
        return np.asarray(np.einsum('nij,nj->ni', roots, rest))

    def chi2(self, values: Array) -> Array:
        """Return the chi-square of each ray, (n,)."""
        return np.asarray((self.residuals(values, self.roots(values))**2).sum(axis=1))

    def started(self) -> Array:
        """Return values that a linear look at the angles tells, with the signs of the joints."""
        turns = self.turns(0.0)
        design = np.column_stack([turns - turns.mean(axis=0), np.ones(len(turns))])
        if np.linalg.cond(design[:, :2]) > 100.0:
            raise HandEyeError(
                'pan and tilt were always turned together: turn each while the other stands still'
            )
        slopes = np.linalg.lstsq(design, self.rays.angles, rcond=None)[0]
        if 0.5 < math.degrees(np.abs(slopes[:2]).max()) < 2.0:
            raise HandEyeError(
                'the light turns by a degree where a joint turns by 1: are the angles in '
                'degrees, not rad?'
            )
        across, up = -slopes[0], -slopes[1]
        if abs(across[0]) < abs(across[1]) or abs(up[1]) < abs(up[0]):
            raise HandEyeError(
                'pan does not turn the camera to the side or tilt does not turn it up: are the '
                'two exchanged, or is the camera mounted on its side?'
            )
        self.frame[0] *= np.sign(across[0])
        self.frame[1] *= np.sign(up[1])
        mean = turns.mean(axis=0) * [np.sign(across[0]), np.sign(up[1])]
        azimuth, elevation = self.rays.angles.mean(axis=0) + mean
        self.frame[2] = [
            math.cos(elevation) * math.sin(azimuth), -math.sin(elevation),
            math.cos(elevation) * math.cos(azimuth),
        ]
        return np.zeros(len(NAMES))

    def fitted(self, values: Array, kept: NDArray[np.bool_]) -> Array:
        """Return the values of least squares."""
        roots = self.roots(values)
        return np.asarray(least_squares(
            lambda each: self.residuals(each, roots)[kept].ravel(), values, method='lm',
            x_scale='jac',
        ).x)

    def information(self, values: Array, kept: NDArray[np.bool_]) -> Array:
        """Return the Fisher information of the values."""
        roots, slopes = self.roots(values), []
        for step in 1e-6 * np.eye(len(NAMES)):
            slopes.append((
                self.residuals(values + step, roots) - self.residuals(values - step, roots)
            )[kept].ravel() / 2e-6)
        jacobian = np.array(slopes)
        return np.asarray(jacobian @ jacobian.T)


def _judged(
    problem: _Problem, values: Array, kept: NDArray[np.bool_],
    distance: tuple[float, float] | None, most_offset: float,
) -> HandEyeCalibration:
    """Return the calibration with its covariance, or raise where it is none."""
    residuals = problem.residuals(values, problem.roots(values))[kept]
    chi2, freedom = float((residuals**2).sum()), 2 * int(kept.sum()) - len(NAMES)
    factor = variance_factor(chi2, freedom, known=True)
    if factor > MOST_FACTOR:
        raise HandEyeError(
            f'the residuals are {factor**0.5:.0f} times what the sigmas say, and may be '
            f'{MOST_FACTOR**0.5:.0f} times that: the light moved, the tilt carries the pan (the '
            'pan must carry the tilt), the focal length is wrong, or the joints have backlash or '
            'coarse angles: --joint-sigma'
        )
    try:
        covariance = factor * np.linalg.inv(problem.information(values, kept))
    except np.linalg.LinAlgError:
        raise HandEyeError('the rays do not give the axes: turn both joints further') from None
    (pan_axis, across_pan), (tilt_axis, across_tilt), (light, _) = problem.axes(values)
    scale, relative = (distance[0], distance[1] / distance[0]) if distance else (1.0, 0.0)
    sizes = np.ones(len(NAMES))
    sizes[ARMS] = scale
    along = np.zeros(len(NAMES))
    along[ARMS] = scale * values[ARMS]
    covariance = covariance * np.outer(sizes, sizes) + relative**2 * np.outer(along, along)
    worst = float(np.sqrt(np.diag(covariance)[AXES].max()))
    if not worst < VAGUE_RAD:
        raise HandEyeError(
            f'an axis is known to {math.degrees(worst):.1f} degrees only: turn both joints '
            'further, into the corners of the picture'
        )
    if max(abs(pan_axis @ tilt_axis), np.abs(values[AXES]).max()) > SQUARE_RAD:
        raise HandEyeError(
            'the axes are far from square to each other, or to the camera: do both joints carry '
            'it, and does the light stand still?'
        )
    if abs(values[CLOCK]) > most_offset:
        raise HandEyeError(
            f'the stamps of the rays are {values[CLOCK]:.3f} s late by those of the angles, and '
            f'may be {most_offset:g} s early or late: are they of one clock?'
        )
    return HandEyeCalibration(
        pan_axis, tilt_axis, scale * values[4:6] @ across_pan, scale * values[6:8] @ across_tilt,
        light, float(values[CLOCK]), covariance, distance is not None, int(kept.sum()),
        int((~kept).sum()), chi2, freedom, factor, residuals,
        problem.turns(values[CLOCK])[kept],
    )


def _check(
    rays: Rays, pan: Joint, tilt: Joint, joint_sigma: float,
    distance: tuple[float, float] | None,
) -> None:
    if len(rays.times) < FEWEST:
        raise HandEyeError(f'{len(rays.times)} rays; {FEWEST} are the least')
    for name, joint in (('pan', pan), ('tilt', tilt)):
        if len(joint.times) < 4 or not np.isfinite(joint.angles).all():
            raise HandEyeError(f'{name} has too few angles, or some that are not numbers')
    if not 0.0 <= joint_sigma < 0.1:
        raise HandEyeError(f'the sigma of a joint is {joint_sigma:g} rad; it must be 0 to 0.1')
    if distance and not (0.0 < distance[0] < math.inf and 0.0 <= distance[1] < distance[0]):
        raise HandEyeError(
            f'the light is {distance[0]:g} m away with a deviation of {distance[1]:g} m; a '
            'range is above 0 and above its standard deviation'
        )

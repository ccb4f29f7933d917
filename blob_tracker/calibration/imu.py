"""How a gyro sits beside a camera, from turning both before a light that stands still."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from blob_tracker.tracking.gyro_fit import fit_gyro, moves_of
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
import scipy.linalg
from scipy.optimize import least_squares, minimize_scalar
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

NAMES = ('turn_x', 'turn_y', 'turn_z', 'offset', 'bias_x', 'bias_y', 'bias_z', 'scale')
FEWEST = 100  # intervals between two bearings, for 8 unknowns and a noise
LONGEST_S = 0.3  # of an interval
SHORTEST_S = 0.08  # of one of the first look
MARGIN_S = 0.25  # that the gyro is to cover beyond the bearings: an offset within it is found
ROUNDS = 2  # of the fit, each with the noise of the one before
# rad/s/sqrt(Hz): from better than any gyro to what no gyro has.
LEAST_NOISE, MOST_NOISE = 1e-7, 1.0
BAD_NOISE = 5e-3  # 0.3 degrees/s/sqrt(Hz), thirty times that of a cheap one
VAGUE_RAD = 0.05  # of the turn: with it the tracker is as well off without the gyro
CORRELATED = 6.0  # standard deviations of a correlation of what is left: no noise


class ImuError(ValueError):
    """Samples that tell nothing of how the gyro sits; the message says why."""


@dataclass(frozen=True)
class ImuCalibration:
    """
    How a gyro sits beside a camera.

    Parameters
    ----------
    turn : (3, 3) array
        Takes components in the IMU to those in the camera's optical frame.
    offset : float
        How late the stamps of the gyro are, s, by those of the bearings.
    bias : (3,) array
        That the gyro says at rest, in its own axes, rad/s.
    scale : float
        By which the camera sees it turn further than the gyro says, as a part: of the gyro, or of
        the focal length.
    noise : float
        Density of the gyro's noise, rad/s/sqrt(Hz).
    covariance : (8, 8) array
        Of the turn about x, y and z of the camera (rad), offset, bias and scale.
    times : (n,) array
        Ends of the intervals, s.
    residuals : (n, 2) array
        Measured less predicted at the end of each interval, over its standard deviation and
        without what it shares with the former ones.

    """

    turn: Array
    offset: float
    bias: Array
    scale: float
    noise: float
    covariance: Array
    times: Array
    residuals: Array

    @property
    def sigmas(self) -> Array:
        """Return the standard deviations of the 8, in that order."""
        return np.sqrt(np.diag(self.covariance))


def calibrate_imu(
    times: Array, directions: Array, covariances: Array, gyro_times: Array, rates: Array
) -> ImuCalibration:
    """
    Fit the turn, the offset of the stamps, the bias and the scale of a gyro.

    From one bearing to the next the light's direction turns by the vector

        v = (1 + s) C (-a + 1/2 int w x (a - a0) dt),    w = rate - bias,  a = int w dt

    over the interval, by the gyro's clock (Magnus expansion; C takes the IMU's axes to the
    camera's). The residuals have the noise of both bearings, of which two neighbours share one,
    and of the gyro, whose density is the likeliest.

    Parameters
    ----------
    times : (n,) array
        Of the bearings, s, rising.
    directions : (n, 3) array
        Of the light in the optical frame, of length 1.
    covariances : (n, 2, 2) array
        Of azimuth and elevation, rad^2.
    gyro_times : (m,) array
        s, rising, of the same origin.
    rates : (m, 3) array
        In the IMU's axes, rad/s.

    Raises
    ------
    ImuError
        Where they tell nothing, with what to do.

    """
    known = np.isfinite(directions).all(axis=1) & np.isfinite(covariances).all(axis=(1, 2))
    times, directions, covariances = _each_once(
        times[known], directions[known], covariances[known]
    )
    gyro_times, rates = _each_once(gyro_times, rates)
    if len(gyro_times) < FEWEST:
        raise ImuError(f'{len(gyro_times)} samples of the gyro; {FEWEST} are the least')
    if not np.isfinite(rates).all():
        raise ImuError('some rates of the gyro are no numbers: is it starting or failing?')
    if not rates.any():
        raise ImuError('all rates of the gyro are 0: does its driver fill in angular_velocity?')
    within = (times > gyro_times[0] + MARGIN_S) & (times < gyro_times[-1] - MARGIN_S)
    times, directions, covariances = times[within], directions[within], covariances[within]
    pairs = np.flatnonzero(np.diff(times) <= LONGEST_S)
    if len(pairs) < FEWEST:
        raise ImuError(
            f'{len(pairs)} pairs of bearings follow each other within {LONGEST_S:g} s while the '
            f'gyro speaks; {FEWEST} are the least: turn for half a minute, with the light in view'
        )
    start = _start(times, directions, gyro_times, rates)
    problem = _Problem(times, directions, covariances, pairs, gyro_times, rates, start)
    parameters, noise = np.zeros(len(NAMES)), 1e-3
    for _ in range(ROUNDS):
        root = problem.root(problem.covariance(parameters), noise)
        fit = least_squares(
            lambda each: problem.whitened(each, root), parameters, method='lm', x_scale='jac',
        )
        parameters = fit.x
        noise = problem.noise(parameters)
    root = problem.root(problem.covariance(parameters), noise)
    left = problem.whitened(parameters, root)
    size = np.linalg.norm(fit.jac, axis=0)
    normal = (fit.jac / size).T @ (fit.jac / size)
    values, vectors = np.linalg.eigh(normal)
    inverse = vectors / np.maximum(values, 1e-14) @ vectors.T / np.outer(size, size)
    residuals = left.reshape(-1, 2)
    _check(inverse, noise, residuals)
    turn = (Rotation.from_rotvec(parameters[:3]) * Rotation.from_matrix(start)).as_matrix()
    return ImuCalibration(
        turn, float(parameters[3]), parameters[4:7], float(parameters[7]), noise, inverse,
        times[pairs + 1], residuals,
    )


def _each_once(times: Array, *values: Array) -> tuple[Array, ...]:
    """Return samples in the order of their stamps, the first of each stamp."""
    rising, first = np.unique(times, return_index=True)
    return rising, *(each[first] for each in values)


def _start(times: Array, directions: Array, gyro_times: Array, rates: Array) -> Array:
    """Return the turn to begin with, or raise where there was too little turning."""
    moves = moves_of(times, directions, SHORTEST_S, LONGEST_S)
    told, fault = fit_gyro(moves, gyro_times, rates)
    if not told:
        raise ImuError(
            'the light moves too little in the picture, or otherwise than the gyro says: turn '
            'camera and IMU together, by 20 degrees and more to either side, about all axes'
        )
    if fault is None:
        return np.eye(3)
    if fault.turn is None:
        raise ImuError(
            f'{fault.words}: are both on the same platform, and the stamps of one clock?'
        )
    if fault.scale != 1.0:
        raise ImuError(f'{fault.words}: have the driver publish rad/s, and record again')
    # Of a light ahead the picture hardly shows a turn about its own axis: the hand tells it.
    first, second = fault.turn[0], fault.turn[1]
    return np.stack([first, second, np.cross(first, second)])


class _Problem:
    """The residuals of the intervals, and their covariance."""

    def __init__(
        self, times: Array, directions: Array, covariances: Array, pairs: NDArray[np.intp],
        gyro_times: Array, rates: Array, start: Array,
    ) -> None:
        self._begin, self._end = times[pairs], times[pairs + 1]
        self._before, self._after = directions[pairs], directions[pairs + 1]
        self._gyro_times, self._rates, self._start = gyro_times, rates, start
        self._angle = CubicSpline(gyro_times, rates).antiderivative()
        # Azimuth and elevation as turns across the direction: right and up.
        x, y, z = directions.T
        across = np.hypot(x, z)
        right = np.stack([z / across, np.zeros_like(x), -x / across], axis=1)
        axes = np.stack([right, np.cross(directions, right)], axis=2)
        shrink = np.stack([across, np.ones_like(x)], axis=1)
        covariances = covariances * shrink[:, :, None] * shrink[:, None, :]
        self._axes_before, self._axes_after = axes[pairs], axes[pairs + 1]
        self._of_before, self._of_after = covariances[pairs], covariances[pairs + 1]
        self._next = np.diff(pairs) == 1  # whether an interval begins where the former ended

    def _turns(self, parameters: Array) -> Rotation:
        """Return how the light's direction turns over each interval."""
        times, bias = self._gyro_times, parameters[4:7]
        product = np.cross(self._rates - bias, self._angle(times) - np.outer(times, bias))
        steps = 0.5 * (product[1:] + product[:-1]) * np.diff(times)[:, None]
        cones = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])

        def at(instants: Array) -> tuple[Array, Array]:
            cone = np.stack([np.interp(instants, times, each) for each in cones.T], axis=1)
            return self._angle(instants) - np.outer(instants, bias), cone

        (before, cone_before), (after, cone_after) = (
            at(each + parameters[3]) for each in (self._begin, self._end)
        )
        turned = after - before
        vector = -turned + 0.5 * (cone_after - cone_before - np.cross(turned, before))
        matrix = Rotation.from_rotvec(parameters[:3]).as_matrix() @ self._start
        return Rotation.from_rotvec((1.0 + parameters[7]) * vector @ matrix.T)

    def residuals(self, parameters: Array) -> Array:
        """Return (n, 2) measured less predicted, right and up, rad."""
        rest = self._after - self._turns(parameters).apply(self._before)
        return np.asarray(np.einsum('nik,ni->nk', self._axes_after, rest))

    def covariance(self, parameters: Array) -> tuple[Array, Array]:
        """Return the residuals' covariance by the bearings: of each, and with the former one."""
        turns = self._turns(parameters).as_matrix()
        carried = np.swapaxes(self._axes_after, 1, 2) @ turns @ self._axes_before
        own = self._of_after + carried @ self._of_before @ np.swapaxes(carried, 1, 2)
        shared = -(carried @ self._of_before)[1:] * self._next[:, None, None]
        return own, shared

    def root(self, covariance: tuple[Array, Array], noise: float) -> Array:
        """Return the Cholesky factor of the covariance with the gyro's noise, its lower bands."""
        own, shared = covariance
        own = own + noise**2 * (self._end - self._begin)[:, None, None] * np.eye(2)
        bands = np.zeros((4, 2 * len(own)))
        bands[0] = np.stack([own[:, 0, 0], own[:, 1, 1]], axis=1).ravel()
        bands[1, 0::2] = own[:, 1, 0]
        # Of the pair (row, column) of two blocks the band is 2 + row - column.
        bands[1, 1:-2:2] = shared[:, 0, 1]
        bands[2, 0:-2:2], bands[2, 1:-2:2] = shared[:, 0, 0], shared[:, 1, 1]
        bands[3, 0:-2:2] = shared[:, 1, 0]
        return np.asarray(scipy.linalg.cholesky_banded(bands, lower=True))

    def whitened(self, parameters: Array, root: Array) -> Array:
        """Return (2 n,) residuals that are uncorrelated and of variance 1."""
        rest = self.residuals(parameters).ravel()
        return np.asarray(scipy.linalg.solve_banded((3, 0), root, rest))

    def noise(self, parameters: Array) -> float:
        """Return the likeliest density of the gyro's noise, rad/s/sqrt(Hz)."""
        covariance, rest = self.covariance(parameters), self.residuals(parameters).ravel()

        def unlikely(logarithm: float) -> float:
            root = self.root(covariance, float(np.exp(logarithm)))
            left = scipy.linalg.solve_banded((3, 0), root, rest)
            return float(0.5 * left @ left + np.log(root[0]).sum())

        bounds = np.log(LEAST_NOISE), np.log(MOST_NOISE)
        found = minimize_scalar(unlikely, bounds=bounds, method='bounded')
        return float(np.exp(found.x))


def _check(covariance: Array, noise: float, residuals: Array) -> None:
    """Raise ImuError where the fit is none."""
    # About 0 where it is noise, with a standard deviation of 1 over the root of their number.
    count = residuals[1:].size
    shared = float((residuals[1:] * residuals[:-1]).mean() / (residuals**2).mean())
    if noise > BAD_NOISE or abs(shared) > CORRELATED / sqrt(count):
        raise ImuError(
            f'the light moves otherwise than camera and gyro do ({noise:.2g} rad/s/sqrt(Hz) are '
            f'left, correlated by {shared:.2f}): it must stand still, far off or where the camera '
            'turns on the spot, and the IMU must be rigid with the camera'
        )
    values, vectors = np.linalg.eigh(covariance[:3, :3])
    if values[-1] > VAGUE_RAD**2:
        axis = 'xyz'[int(np.abs(vectors[:, -1]).argmax())]
        raise ImuError(
            f'the turn about {axis} of the camera is known to '
            f'{180.0 / pi * sqrt(values[-1]):.0f} degrees only: turn about two axes and more, nod '
            'and swing'
        )

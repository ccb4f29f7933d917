"""What a camera saw from one bearing to the next, against what a gyro said of it."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
import scipy.linalg
from scipy.optimize import least_squares, minimize_scalar
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NAMES = ('turn_x', 'turn_y', 'turn_z', 'offset', 'bias_x', 'bias_y', 'bias_z', 'scale')
STEP_S = 0.0125  # of the sum of the rates' cross products, at most
DIFFERENCE = 1e-6  # of a parameter: rad, s, rad/s or a part
RIDGE = 0.1  # per unit of a parameter, of what most intervals leave
STRAY = 6.0  # times the median of what is left of an interval
# rad/s/sqrt(Hz): from better than any gyro to what no gyro has.
LEAST_NOISE, MOST_NOISE = 1e-7, 1.0


class ImuProblem:
    """The residuals of intervals, and their covariance, by the 8 parameters in `NAMES`."""

    def __init__(
        self, times: Array, directions: Array, covariances: Array,
        pairs: tuple[Indices, Indices], gyro_times: Array, rates: Array, start: Array,
    ) -> None:
        first, last = pairs
        self._begin, self._end = times[first], times[last]
        self._before, self._after = directions[first], directions[last]
        rate = CubicSpline(gyro_times, rates)
        self._angle, self._start = rate.antiderivative(), start
        # The cones are summed up in steps that are short beside a swing, however slow the gyro.
        parts = ceil(float(np.median(np.diff(gyro_times))) / STEP_S)
        whole = np.arange(len(gyro_times))
        self._gyro_times = np.interp(
            np.arange(parts * (len(whole) - 1) + 1) / parts, whole, gyro_times)
        self._rates = rate(self._gyro_times)
        # Azimuth and elevation as turns across the direction: right and up.
        x, y, z = directions.T
        across = np.hypot(x, z)
        right = np.stack([z / across, np.zeros_like(x), -x / across], axis=1)
        axes = np.stack([right, np.cross(directions, right)], axis=2)
        shrink = np.stack([across, np.ones_like(x)], axis=1)
        covariances = covariances * shrink[:, :, None] * shrink[:, None, :]
        self._axes_before, self._axes_after = axes[first], axes[last]
        self._of_before, self._of_after = covariances[first], covariances[last]
        self._next = first[1:] == last[:-1]  # whether an interval begins where the former ended

    def robust(self) -> Array:
        """Return the parameters that most of the intervals agree on, those untold at 0."""
        zero = np.zeros(len(NAMES))
        size = np.median(np.abs(self.residuals(zero)))
        return np.asarray(least_squares(
            lambda each: np.concatenate([self.residuals(each).ravel() / size, RIDGE * each]),
            zero, loss='cauchy', f_scale=0.2, x_scale='jac', xtol=1e-6, ftol=1e-6,
        ).x)

    def agree(self, parameters: Array) -> NDArray[np.bool_]:
        """Return which intervals agree with parameters about as well as most do."""
        size = np.linalg.norm(self.residuals(parameters), axis=1)
        return np.asarray(size <= STRAY * np.median(size))

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
        """
        Return the likeliest density of the gyro's noise, rad/s/sqrt(Hz).

        The likelihood is that of what the parameters leave free (restricted, REML): that of all
        residuals takes the noise for too small, as the fit has gone after it.
        """
        covariance, rest = self.covariance(parameters), self.residuals(parameters).ravel()
        free = np.column_stack([
            (self.residuals(parameters + each) - self.residuals(parameters - each)).ravel()
            for each in DIFFERENCE * np.eye(len(NAMES))
        ])
        both = np.column_stack([rest, free / np.linalg.norm(free, axis=0)])

        def unlikely(logarithm: float) -> float:
            root = self.root(covariance, float(np.exp(logarithm)))
            left = scipy.linalg.solve_banded((3, 0), root, both)
            taken = np.linalg.slogdet(left[:, 1:].T @ left[:, 1:])[1]
            return float(0.5 * left[:, 0] @ left[:, 0] + np.log(root[0]).sum() + 0.5 * taken)

        bounds = np.log(LEAST_NOISE), np.log(MOST_NOISE)
        found = minimize_scalar(unlikely, bounds=bounds, method='bounded')
        return float(np.exp(found.x))

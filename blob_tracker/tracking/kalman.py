"""The Kalman filter: a state predicted over any interval, and updated by a bearing."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking.direction import moved, offset, placed, State, turned_covariance
from blob_tracker.tracking.models import fill_step
from blob_tracker.tracking.rotation import product
import numpy as np


# Of each variance: more than rounding can take where a bearing is a million times better than what
# was expected, so that no correlation reaches 1; of a standard deviation it is 5e-10.
ROUNDING = 1e-9


class Step(NamedTuple):
    """
    The way from one instant to the next.

    Parameters
    ----------
    seconds : float
        s.
    density : float
        Spectral density of the process noise, mrad^2/s^3 or mrad^2/s^5.
    turn : (3, 3) array
        Takes components in the base as it was to those in the base as it is then.
    variance : float
        Of each angle of that turn, mrad^2.

    """

    seconds: float
    density: float
    turn: Array
    variance: float


class Measurement(NamedTuple):
    """
    A bearing, and how its camera stood.

    Parameters
    ----------
    azimuth, elevation : float
        mrad.
    azimuth_variance, shared, elevation_variance : float
        Its covariance, mrad^2.
    camera : (3, 3) array
        Axes of the camera in the base, as columns.

    """

    azimuth: float
    elevation: float
    azimuth_variance: float
    shared: float
    elevation_variance: float
    camera: Array


class Innovation(NamedTuple):
    """
    What a bearing brought that was not predicted.

    Parameters
    ----------
    first, second : float
        The innovation over the Cholesky factor of its covariance: uncorrelated, of variance 1.
    log_determinant : float
        Of its covariance, in mrad^2.

    """

    first: float
    second: float
    log_determinant: float

    @property
    def squared(self) -> float:
        """Normalised innovation squared: chi-square with two degrees of freedom."""
        return self.first**2 + self.second**2


@kernel
def _across(axes: Array, place: Array, measurement: Measurement) -> tuple[float, float, float]:
    """Return the bearing's covariance as that of turns right and up of some axes."""
    variances = measurement.azimuth_variance, measurement.shared, measurement.elevation_variance
    return turned_covariance(axes, place, measurement.elevation, variances)


@kernel
def initiated(measurement: Measurement, rate: float, acceleration: float, size: int) -> State:
    """
    Return the state that one bearing gives, with what may be expected of the motion.

    Parameters
    ----------
    measurement : Measurement
        The first bearing.
    rate, acceleration : float
        Standard deviations of the motion at first sight, mrad/s and mrad/s^2; their mean is 0.
    size : int
        Numbers in the state.

    """
    axes = placed(measurement.azimuth, measurement.elevation, measurement.camera)
    covariance = np.zeros((size, size))
    rr, ru, uu = _across(axes, axes, measurement)
    covariance[0, 0], covariance[1, 1] = rr, uu
    covariance[0, 1] = covariance[1, 0] = ru
    for k in range(2, size):
        covariance[k, k] = rate * rate if k < 4 else acceleration * acceleration
    return State(axes, np.zeros(size - 2), covariance)


@kernel
def predicted(state: State, step: Step) -> State:
    """
    Return the state after a step: x = F x, P = F P F^T + Q, on the sphere.

    The direction goes along a great circle, and with the base's rotation.
    """
    size = state.covariance.shape[0]
    transition, noise = np.empty((size, size)), np.empty((size, size))
    fill_step(step.seconds, step.density, transition, noise)
    right, up = 0.0, 0.0
    motion = np.zeros(size - 2)
    for k in range(size - 2):
        right += transition[0, 2 + k] * state.motion[k]
        up += transition[1, 2 + k] * state.motion[k]
        for m in range(size - 2):
            motion[k] += transition[2 + k, 2 + m] * state.motion[m]
    covariance = product(product(transition, state.covariance), transition.T.copy())
    for k in range(size):
        for m in range(k + 1):
            # The mean of both halves: rounding must not make them differ, step after step.
            value = 0.5 * (covariance[k, m] + covariance[m, k]) + noise[k, m]
            covariance[k, m] = covariance[m, k] = value
    covariance[0, 0] += step.variance
    covariance[1, 1] += step.variance
    return State(product(step.turn, moved(state.axes, right, up)), motion, covariance)


@kernel
def updated(
    state: State, measurement: Measurement, gate_squared: float
) -> tuple[bool, State, Innovation]:
    """
    Return whether a bearing passes the gate, the state that it updates, and its innovation.

    With the innovation v, its covariance S = P_angles + R inverted in closed form and the gain
    K = P H^T / S, the covariance is Joseph's (I - K H) P (I - K H)^T + K R K^T, symmetric and a
    sum of squares, and a little more: what rounding may have taken.

    Parameters
    ----------
    state : State
        Predicted to the bearing's instant.
    measurement : Measurement
        The bearing.
    gate_squared : float
        Largest v^T S^-1 v: the square of a Mahalanobis distance in sigma.

    """
    size = state.covariance.shape[0]
    before = state.covariance
    axes = placed(measurement.azimuth, measurement.elevation, measurement.camera)
    rr, ru, uu = _across(state.axes, axes, measurement)
    right, up = offset(state.axes, axes[0, 2], axes[1, 2], axes[2, 2])
    a, b, c = before[0, 0] + rr, before[1, 0] + ru, before[1, 1] + uu
    # Cholesky of S: the second pivot is the variance of up once right is known.
    rest = c - b * b / a
    innovation = Innovation(
        right / math.sqrt(a), (up - b / a * right) / math.sqrt(rest), math.log(a) + math.log(rest)
    )
    if not innovation.first**2 + innovation.second**2 <= gate_squared:
        return False, state, innovation
    determinant = a * rest
    gain = np.empty((size, 2))
    change = np.empty(size)
    for k in range(size):
        p, q = before[k, 0], before[k, 1]
        gain[k, 0] = (p * c - q * b) / determinant
        gain[k, 1] = (q * a - p * b) / determinant
        change[k] = gain[k, 0] * right + gain[k, 1] * up
    kept = np.empty((size, size))  # (I - K H) P
    for k in range(size):
        for m in range(size):
            kept[k, m] = before[k, m] - gain[k, 0] * before[0, m] - gain[k, 1] * before[1, m]
    covariance = np.empty((size, size))
    for k in range(size):
        for m in range(k + 1):
            g, h = gain[m, 0], gain[m, 1]
            value = kept[k, m] - kept[k, 0] * g - kept[k, 1] * h
            value += gain[k, 0] * (rr * g + ru * h) + gain[k, 1] * (ru * g + uu * h)
            if m == k:
                value *= 1.0 + ROUNDING
            covariance[k, m] = covariance[m, k] = value
    motion = np.empty(size - 2)
    for k in range(size - 2):
        motion[k] = state.motion[k] + change[2 + k]
    return True, State(moved(state.axes, change[0], change[1]), motion, covariance), innovation


@kernel
def with_motion_forgotten(state: State, rate: float, acceleration: float) -> State:
    """Return the direction of a state with the motion as at first sight; see `initiated`."""
    size = state.covariance.shape[0]
    covariance = np.zeros((size, size))
    covariance[:2, :2] = state.covariance[:2, :2]
    for k in range(2, size):
        covariance[k, k] = rate * rate if k < 4 else acceleration * acceleration
    return State(state.axes, np.zeros(size - 2), covariance)


@kernel
def largest_deviation(state: State) -> float:
    """Return the largest standard deviation of the direction, mrad."""
    a, b, c = state.covariance[0, 0], state.covariance[1, 0], state.covariance[1, 1]
    return math.sqrt(0.5 * (a + c) + math.hypot(0.5 * (a - c), b))

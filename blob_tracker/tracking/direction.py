"""
A direction on the sphere with its motion, and how it is turned, moved and read as angles.

Azimuth has a pole, where its rate and variance are without bounds, and a seam. So the filter's
angles are small turns about axes that go with the direction, and only what is handed out is read
as azimuth and elevation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking.rotation import from_vector, pan_tilt, product
from blob_tracker.units import MRAD
import numpy as np

NEAREST_POLE = 1e-9  # cosine of the elevation, below which the azimuth is arbitrary


class State(NamedTuple):
    """
    What the filter knows: a direction, its motion, and how well.

    Parameters
    ----------
    axes : (3, 3) array
        The direction as z axis, in components of the base, and an x and a y axis across it. They
        are carried along great circles without a twist.
    motion : (n - 2,) array
        Rates right and up, that is along x and against y, mrad/s; then accelerations, mrad/s^2.
    covariance : (n, n) array
        Of the direction's turns right and up, mrad^2, and of the motion.

    """

    axes: Array
    motion: Array
    covariance: Array


@kernel
def moved(axes: Array, right: float, up: float) -> Array:
    """Return the axes after a turn along a great circle, mrad."""
    return product(axes, from_vector(MRAD * up, MRAD * right, 0.0))


@kernel
def offset(axes: Array, x: float, y: float, z: float) -> tuple[float, float]:
    """Return the turn, right and up in mrad, that `moved` needs to get to a unit vector."""
    right = axes[0, 0] * x + axes[1, 0] * y + axes[2, 0] * z
    up = -(axes[0, 1] * x + axes[1, 1] * y + axes[2, 1] * z)
    ahead = axes[0, 2] * x + axes[1, 2] * y + axes[2, 2] * z
    sine = math.hypot(right, up)
    scale = math.atan2(sine, ahead) / sine if sine > 0.0 else 1.0
    return scale * right / MRAD, scale * up / MRAD


@kernel
def placed(azimuth: float, elevation: float, camera: Array) -> Array:
    """Return the axes at a bearing, mrad, of a camera; its axes in the base are the columns."""
    return product(camera, pan_tilt(MRAD * azimuth, MRAD * elevation))


@kernel
def turned_covariance(
    axes: Array, seen: Array, elevation: float, variances: tuple[float, float, float]
) -> tuple[float, float, float]:
    """
    Return the covariance of azimuth and elevation as that of turns right and up of other axes.

    Parameters
    ----------
    axes : (3, 3) array
        The other axes.
    seen : (3, 3) array
        Axes at the bearing, as `placed` returns them.
    elevation : float
        mrad.
    variances : tuple of float
        Of azimuth, of both and of elevation, mrad^2.

    Returns
    -------
    tuple of float
        The same of right and up.

    """
    # A turn of azimuth moves the direction by less the higher it is.
    shrunk = math.cos(MRAD * elevation)
    rr = shrunk * shrunk * variances[0]
    ru = shrunk * variances[1]
    uu = variances[2]
    a = axes[0, 0] * seen[0, 0] + axes[1, 0] * seen[1, 0] + axes[2, 0] * seen[2, 0]
    b = -(axes[0, 0] * seen[0, 1] + axes[1, 0] * seen[1, 1] + axes[2, 0] * seen[2, 1])
    c = -(axes[0, 1] * seen[0, 0] + axes[1, 1] * seen[1, 0] + axes[2, 1] * seen[2, 0])
    d = axes[0, 1] * seen[0, 1] + axes[1, 1] * seen[1, 1] + axes[2, 1] * seen[2, 1]
    return (
        a * a * rr + 2.0 * a * b * ru + b * b * uu,
        a * c * rr + (a * d + b * c) * ru + b * d * uu,
        c * c * rr + 2.0 * c * d * ru + d * d * uu,
    )


@kernel
def with_rates(state: State, rotation: Array, sign: float, acceleration: float) -> State:
    """
    Return the state with the rates of a frame added (sign +1) or taken off (-1).

    Parameters
    ----------
    state : State
        Its rates are those against the turning frame, or against one that does not turn.
    rotation : (3,) array
        Angular velocity of the frame in the base, rad/s.
    sign : float
        +1 where the rates were against the frame.
    acceleration : float
        Standard deviation of the accelerations then, mrad/s^2: of the frame's nothing is known.

    """
    axes = state.axes
    motion, covariance = state.motion.copy(), state.covariance.copy()
    x = axes[0, 0] * rotation[0] + axes[1, 0] * rotation[1] + axes[2, 0] * rotation[2]
    y = axes[0, 1] * rotation[0] + axes[1, 1] * rotation[1] + axes[2, 1] * rotation[2]
    motion[0] += sign * y / MRAD
    motion[1] += sign * x / MRAD
    for k in range(4, covariance.shape[0]):
        motion[k - 2] = 0.0
        covariance[k, :] = 0.0
        covariance[:, k] = 0.0
        covariance[k, k] = acceleration * acceleration
    return State(axes, motion, covariance)


@kernel
def as_angles(state: State, frame: Array) -> tuple[Array, Array]:
    """
    Return a state as azimuth, elevation and their derivatives, and its covariance.

    With the direction (X, Y, Z) in the frame and h^2 = X^2 + Z^2, azimuth = atan2(X, Z) and
    elevation = atan2(-Y, h); the derivatives are those along the path, the covariance is carried
    through the derivative of both angles by the turns right and up.

    Parameters
    ----------
    state : State
        In components of the base.
    frame : (3, 3) array
        Axes of the frame of the angles in the base, as columns.

    Returns
    -------
    (n,) array, (n, n) array
        mrad, mrad/s, mrad/s^2.

    """
    axes = product(frame.T.copy(), state.axes)
    size = state.covariance.shape[0]
    x, y, z = axes[0, 2], axes[1, 2], axes[2, 2]
    square = max(x * x + z * z, NEAREST_POLE * NEAREST_POLE)
    h = math.sqrt(square)
    by = np.empty((2, 2))
    by[0, 0] = (z * axes[0, 0] - x * axes[2, 0]) / square
    by[0, 1] = -(z * axes[0, 1] - x * axes[2, 1]) / square
    by[1, 0], by[1, 1] = -axes[1, 0] / h, axes[1, 1] / h
    out = np.empty(size)
    out[0], out[1] = math.atan2(x, z) / MRAD, math.atan2(-y, math.hypot(x, z)) / MRAD
    right, up = state.motion[0], state.motion[1]
    out[2] = by[0, 0] * right + by[0, 1] * up
    out[3] = by[1, 0] * right + by[1, 1] * up
    if size == 6:
        # What the angles' axes turn by along the path counts as acceleration of the angles.
        out[4] = by[0, 0] * state.motion[2] + by[0, 1] * state.motion[3]
        out[5] = by[1, 0] * state.motion[2] + by[1, 1] * state.motion[3]
        tangent = -y / h
        out[4] += 2.0 * MRAD * tangent * out[2] * out[3]
        out[5] -= MRAD * tangent * square * out[2] * out[2]
    covariance = np.empty((size, size))
    inside = state.covariance
    for i in range(0, size, 2):
        for j in range(0, i + 2, 2):
            for k in range(2):
                for m in range(2):
                    total = 0.0
                    for p in range(2):
                        for q in range(2):
                            total += by[k, p] * inside[i + p, j + q] * by[m, q]
                    covariance[i + k, j + m] = covariance[j + m, i + k] = total
    return out, covariance

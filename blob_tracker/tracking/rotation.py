"""Rotation matrices."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
import numpy as np

NO_TURN = np.eye(3)


@kernel
def from_vector(x: float, y: float, z: float) -> Array:
    """
    Return the (3, 3) right-handed turn about a vector by its length, rad (Rodrigues).

    R = I + sin(a)/a K + (1 - cos(a))/a^2 K^2 with the cross-product matrix K of the vector.
    """
    square = x * x + y * y + z * z
    if square < 1e-4:  # where the series' next terms are below rounding
        s = 1.0 - square / 6.0 * (1.0 - square / 20.0)
        c = 0.5 - square / 24.0 * (1.0 - square / 30.0)
    else:
        angle = math.sqrt(square)
        s = math.sin(angle) / angle
        half = math.sin(0.5 * angle)
        c = 2.0 * half * half / square
    turn = np.empty((3, 3))
    turn[0, 0] = 1.0 - c * (y * y + z * z)
    turn[1, 1] = 1.0 - c * (x * x + z * z)
    turn[2, 2] = 1.0 - c * (x * x + y * y)
    turn[0, 1], turn[1, 0] = c * x * y - s * z, c * x * y + s * z
    turn[0, 2], turn[2, 0] = c * x * z + s * y, c * x * z - s * y
    turn[1, 2], turn[2, 1] = c * y * z - s * x, c * y * z + s * x
    return turn


@kernel
def product(left: Array, right: Array) -> Array:
    """Return the product of two small matrices, without the call of BLAS that costs more."""
    rows, inner, columns = left.shape[0], left.shape[1], right.shape[1]
    out = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            total = 0.0
            for k in range(inner):
                total += left[i, k] * right[k, j]
            out[i, j] = total
    return out


@kernel
def pan_tilt(pan: float, tilt: float) -> Array:
    """Return R_y(pan) R_x(tilt), (3, 3): its z axis has this azimuth and elevation, rad."""
    ca, sa, ce, se = math.cos(pan), math.sin(pan), math.cos(tilt), math.sin(tilt)
    turn = np.empty((3, 3))
    turn[0, 0], turn[0, 1], turn[0, 2] = ca, sa * se, sa * ce
    turn[1, 0], turn[1, 1], turn[1, 2] = 0.0, ce, -se
    turn[2, 0], turn[2, 1], turn[2, 2] = -sa, ca * se, ca * ce
    return turn

"""
The lens model equidistant, of fish-eyes (OpenCV's cv2.fisheye).

A ray at the angle theta to the axis is imaged at the distance

    r = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)

from it, on its own side (Kannala and Brandt, IEEE Trans. Pattern Anal. 28 (2006), eq. 6). It goes
past 90 degrees, where Z is 0 and then negative, as far as r grows with theta.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, hypot, inf, pi, sin
from typing import TypeVar

from blob_tracker.camera.lens.definition import Coefficients, Derivative, Vector
import numpy as np
from numpy.typing import NDArray

MOST_STEPS = 100  # six or so do; bisection, at the fold, takes 55
ROUNDING = 2e-16
LOOKS = 1800  # angles at which a fold is looked for

Value = TypeVar('Value', float, NDArray[np.float64])


def image(rays: NDArray[np.float64], coefficients: Coefficients) -> NDArray[np.float64]:
    """Image rays (N, 3) at places (N, 2), focal lengths; NaN for those past a fold."""
    from_axis = np.hypot(rays[:, 0], rays[:, 1])
    theta = np.arctan2(from_axis, rays[:, 2])
    theta = np.where(theta < _fold_angle(coefficients), theta, np.nan)
    # On the axis the side is none, and the place is the axis' own.
    scale = _distance(theta, coefficients)[0] / np.where(from_axis > 0.0, from_axis, 1.0)
    return np.asarray(scale[:, None] * rays[:, :2])


def ray(x: float, y: float, coefficients: Coefficients) -> tuple[Vector, Derivative] | None:
    """
    Find the unit ray that is imaged at a place, by Newton's iteration between two bounds.

    r grows all the way to the fold, so there is one theta to each r up to there; a step that
    leaves the bounds is replaced by halving them.
    """
    r = hypot(x, y)
    low, high = 0.0, _fold_angle(coefficients)
    if not r < _distance(high, coefficients)[0]:
        return None
    theta, slope = min(r, 0.5 * high), 1.0
    for _ in range(MOST_STEPS):
        found, slope = _distance(theta, coefficients)
        if found > r:
            high = theta
        else:
            low = theta
        step = (r - found) / slope if slope > 0.0 else inf
        if abs(step) <= ROUNDING * theta:
            break
        theta = theta + step if low < theta + step < high else 0.5 * (low + high)
    # Across the axis the ray turns by sin(theta) / r, along r by d theta / d r.
    sine, cosine = sin(theta), cos(theta)
    if r == 0.0:
        return (0.0, 0.0, 1.0), ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))
    across, along = sine / r, cosine / slope
    u, v = x / r, y / r
    return (sine * u, sine * v, cosine), (
        (across * v * v + along * u * u, (along - across) * u * v),
        ((along - across) * u * v, across * u * u + along * v * v),
        (-sine * u / slope, -sine * v / slope),
    )


def _distance(theta: Value, coefficients: Coefficients) -> tuple[Value, Value]:
    """Return r and d r / d theta."""
    k1, k2, k3, k4 = coefficients or (0.0, 0.0, 0.0, 0.0)
    t = theta * theta
    return (
        theta * (1.0 + t * (k1 + t * (k2 + t * (k3 + t * k4)))),
        1.0 + t * (3.0 * k1 + t * (5.0 * k2 + t * (7.0 * k3 + t * 9.0 * k4))),
    )


@lru_cache(maxsize=8)
def _fold_angle(coefficients: Coefficients) -> float:
    """Return the least theta at which r no longer grows, pi at most."""
    angles = np.linspace(0.0, pi, LOOKS + 1)
    turns = np.flatnonzero(_distance(angles, coefficients)[1] <= 0.0)
    if not turns.size:
        return pi
    low, high = float(angles[turns[0] - 1]), float(angles[turns[0]])
    for _ in range(MOST_STEPS):
        middle = 0.5 * (low + high)
        if _distance(middle, coefficients)[1] > 0.0:
            low = middle
        else:
            high = middle
    return low

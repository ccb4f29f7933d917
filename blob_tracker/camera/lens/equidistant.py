"""
The lens model equidistant, of fish-eyes (OpenCV's cv2.fisheye).

A ray at the angle theta to the axis is imaged at the distance

    r = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)

from it, on its own side (Kannala and Brandt, IEEE Trans. Pattern Anal. 28 (2006), eq. 6). It goes
past 90 degrees, where Z is 0 and then negative, as far as r grows with theta.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import cos, hypot, inf, pi, sin
from typing import Any, TypeVar

from blob_tracker.camera.lens.definition import (
    Coefficients, Derivative, Lens, Projection, Start, Vector,
)
import numpy as np
from numpy.typing import NDArray

MOST_STEPS = 100  # six or so do; bisection, at the fold, takes 55
ROUNDING = 2e-16
LOOKS = 1800  # angles at which a fold is looked for
FIT_STEPS = 200
FIT_CLOSE = 1e-12  # relative change of what OpenCV fits, at which it ends
WIDEST = 0.5 * pi - 1e-6  # rad, that a ray in front of the lens is off the axis
HALVINGS = 50  # of that: to 1e-15 rad

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


def start(
    points: Sequence[NDArray[np.float64]],
    places: Sequence[NDArray[np.float64]],
    size: tuple[int, int],
) -> Start:
    """Return the least sum of squares, which OpenCV finds."""
    import cv2  # 30 MB, which a node that only asks for bearings never needs

    flags: Any = cv2.fisheye  # OpenCV 5 has them in cv2 itself
    flags = flags if hasattr(flags, 'CALIB_FIX_SKEW') else cv2
    _, matrix, coefficients, rotations, translations = cv2.fisheye.calibrate(
        [each[None] for each in points],
        [each[None] for each in places],
        size,
        np.eye(3),
        np.zeros(4),
        flags=flags.CALIB_RECOMPUTE_EXTRINSIC | flags.CALIB_FIX_SKEW,
        criteria=(cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, FIT_STEPS, FIT_CLOSE),
    )
    return Start(
        np.asarray(matrix, dtype=float),
        np.ravel(coefficients).astype(float),
        np.array(rotations, dtype=float).reshape(-1, 3),
        np.array(translations, dtype=float).reshape(-1, 3),
    )


def project(
    points: NDArray[np.float64],
    rotation: NDArray[np.float64],
    translation: NDArray[np.float64],
    matrix: NDArray[np.float64],
    coefficients: NDArray[np.float64],
) -> Projection:
    """Image the points (N, 3) of a board, mm, with all derivatives."""
    import cv2

    places, jacobian = cv2.fisheye.projectPoints(
        points[:, None], rotation, translation, matrix, coefficients
    )
    # Its order: focal lengths, principal point, coefficients, rotation, translation, skew.
    return Projection(
        np.asarray(places, dtype=float).reshape(-1, 2),
        np.asarray(jacobian[:, :8], dtype=float),
        np.asarray(jacobian[:, 8:14], dtype=float),
    )


def slopes(
    places: NDArray[np.float64], matrix: NDArray[np.float64], coefficients: NDArray[np.float64]
) -> NDArray[np.float64]:
    """
    Return X / Z and Y / Z, (N, 2), of the rays to places (N, 2), px.

    By halving: cv2.fisheye.undistortPoints cuts r, and not theta, at 90 degrees, so that rays at
    the rim come out up to 7 degrees short. What is not in front of the lens is at WIDEST.
    """
    x, y = ((places - matrix[:2, 2]) / matrix[[0, 1], [0, 1]]).T
    r = np.hypot(x, y)
    known = tuple(float(each) for each in coefficients)
    low, high = np.zeros_like(r), np.full_like(r, min(WIDEST, _fold_angle(known)))
    for _ in range(HALVINGS):
        theta = 0.5 * (low + high)
        above = _distance(theta, known)[0] > r
        low, high = np.where(above, low, theta), np.where(above, theta, high)
    scale = np.tan(0.5 * (low + high)) / np.where(r > 0.0, r, 1.0)
    return np.stack([scale * x, scale * y], axis=1)


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


LENS = Lens(
    counts=(0, 4),
    image=image,
    ray=ray,
    names=('k1', 'k2', 'k3', 'k4'),
    start=start,
    project=project,
    slopes=slopes,
    former_names=('fisheye',),
)

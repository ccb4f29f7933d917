"""
The polynomials of plumb_bob and rational_polynomial, as OpenCV defines and orders them.

A ray (x, y, 1) with r^2 = x^2 + y^2 is imaged at

    g = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
    x' = g x + 2 p1 x y + p2 (r^2 + 2 x^2) + s1 r^2 + s2 r^4
    y' = g y + p1 (r^2 + 2 y^2) + 2 p2 x y + s3 r^2 + s4 r^4

and then, with 14 coefficients, on a sensor that is tilted by tau_x and tau_y. The order is k1 k2
p1 p2, k3, k4 k5 k6, s1 s2 s3 s4, tau_x tau_y, what is left out is 0, and plumb_bob (Brown,
"Decentering distortion of lenses", 1966) is the case that ends at k3. (OpenCV, calib3d, "Detailed
description"; the tilt: Louhichi et al., Meas. Sci. Technol. 18 (2007).)
"""

from __future__ import annotations

from functools import lru_cache
import math
from typing import Any, TypeVar

from blob_tracker.camera.lens.definition import Coefficients, Derivative, Projection, Vector
from blob_tracker.kernel import exact_kernel, written_into_kernels
import numpy as np
from numpy.typing import NDArray

COUNT = 14
COUNTS = (0, 4, 5, 8, 12, 14)  # of coefficients; ROS gives either name to each of them
CLOSE_ENOUGH = 2e-14  # focal lengths: 1e-10 px with one of 5000 px
MOST_STEPS = 60  # five or so do, many only if the picture is about to fold
WIDEST_DEG = 89.0  # from the axis, up to where a fold is looked for
FINER = 7  # times that it is looked for, each in a hundredth of the place where it was found
CLOSE_SLOPE = 1e-9  # of X / Z and Y / Z, of many places at once: no picture shows it
SLOPE_STEPS = 100
DIRECTIONS = 16  # in which it is looked for: without p1, p2 and s1 to s4 all are the same

Value = TypeVar('Value', float, NDArray[np.float64])


def image(rays: NDArray[np.float64], coefficients: Coefficients) -> NDArray[np.float64]:
    """Image rays (N, 3) at places (N, 2), focal lengths; NaN for those behind or past a fold."""
    with np.errstate(divide='ignore', invalid='ignore'):
        x, y = rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]
        seen = (rays[:, 2] > 0.0) & (np.hypot(x, y) < _fold_radius(coefficients))
        x, y = np.where(seen, x, np.nan), np.where(seen, y, np.nan)
        places = np.column_stack(_distorted(x, y, _padded(coefficients)[:12])[:2])
    tilt = _tilt(coefficients)
    if tilt is not None:
        tilted = places @ tilt[:, :2].T + tilt[:, 2]
        places = tilted[:, :2] / tilted[:, 2:]
    return places


def ray(x: float, y: float, coefficients: Coefficients) -> tuple[Vector, Derivative] | None:
    """
    Find what is imaged at a place, as (X, Y, 1), by Newton's iteration with shortened steps.

    A step is halved until the error shrinks and the ray stays on this side of the fold: so the
    ray that is found is the lens', not a second one onto the same place from beyond.
    """
    if not any(coefficients):
        return (x, y, 1.0), ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))
    tilt = _tilt(coefficients)
    upright = (1.0, 0.0, 0.0, 1.0)
    if tilt is not None:
        x, y, upright = _untilted(x, y, tilt)
    fold = _fold_radius(coefficients)
    # Without distortion the ray would be the place itself: a start, if it is within the fold.
    shrink = min(1.0, 0.9 * fold / max((x * x + y * y) ** 0.5, 1e-300))
    found, at_x, at_y, xx, xy, yx, yy = _climbed(
        x, y, shrink * x, shrink * y, fold * fold, _padded(coefficients)[:12]
    )
    if not found:
        return None
    a, b, c, d = upright
    return (at_x, at_y, 1.0), (
        (xx * a + xy * c, xx * b + xy * d), (yx * a + yy * c, yx * b + yy * d), (0.0, 0.0),
    )


def compile_lens() -> None:
    """Compile the search for a ray, or load it."""
    ray(0.1, 0.1, (-0.1, 0.01, 1e-3, 1e-3))


def project(
    points: NDArray[np.float64],
    rotation: NDArray[np.float64],
    translation: NDArray[np.float64],
    matrix: NDArray[np.float64],
    coefficients: NDArray[np.float64],
) -> Projection:
    """Image the points (N, 3) of a board, mm, with all derivatives."""
    import cv2  # 30 MB, which a node that only asks for bearings never needs

    places, jacobian = cv2.projectPoints(points, rotation, translation, matrix, coefficients)
    # Its order: rotation, translation, focal lengths, principal point, coefficients.
    return Projection(
        np.asarray(places, dtype=float).reshape(-1, 2),
        np.asarray(jacobian[:, 6:10 + len(coefficients)], dtype=float),
        np.asarray(jacobian[:, :6], dtype=float),
    )


def slopes(
    places: NDArray[np.float64], matrix: NDArray[np.float64], coefficients: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return X / Z and Y / Z, (N, 2), of the rays to places (N, 2), px."""
    import cv2

    criteria = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, SLOPE_STEPS, CLOSE_SLOPE)
    # OpenCV 4 calls what takes criteria by another name.
    undistort: Any = getattr(cv2, 'undistortPointsIter', cv2.undistortPoints)
    rays = undistort(
        places.reshape(-1, 1, 2), matrix, coefficients, R=np.eye(3), P=np.eye(3),
        criteria=criteria,
    )
    return np.asarray(rays, dtype=float).reshape(-1, 2)


def _distorted(
    x: Value, y: Value, coefficients: Coefficients
) -> tuple[Value, Value, tuple[Value, Value, Value, Value]]:
    """Return the place of a ray (x, y, 1) on an upright sensor, and its derivatives; of twelve."""
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = coefficients
    r2 = x * x + y * y
    above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
    g = above / below
    # d g / d r^2
    slope = (
        k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2) - g * (k4 + r2 * (2.0 * k5 + 3.0 * k6 * r2))
    ) / below
    prism_x, prism_y = 2.0 * (s1 + 2.0 * s2 * r2), 2.0 * (s3 + 2.0 * s4 * r2)
    cross = 2.0 * x * y
    return (
        g * x + p1 * cross + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + s2 * r2),
        g * y + p1 * (r2 + 2.0 * y * y) + p2 * cross + r2 * (s3 + s4 * r2),
        (
            g + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x + prism_x * x,
            cross * slope + 2.0 * (p1 * x + p2 * y) + prism_x * y,
            cross * slope + 2.0 * (p1 * x + p2 * y) + prism_y * x,
            g + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x + prism_y * y,
        ),
    )


def _padded(coefficients: Coefficients) -> Coefficients:
    """Return at least 14 coefficients: those that are left out are 0."""
    return coefficients + COUNT * (0.0,)


_distorted_inside = written_into_kernels(_distorted)


@exact_kernel
def _climbed(
    x: float, y: float, at_x: float, at_y: float, fold2: float, coefficients: Coefficients
) -> tuple[bool, float, float, float, float, float, float]:
    """
    Return whether there is a ray onto a place, where, and its derivative by that place.

    Parameters
    ----------
    x, y : float
        The place.
    at_x, at_y : float
        Where to begin.
    fold2 : float
        Square of the radius of the fold.
    coefficients : tuple of 12 floats
        As of `_distorted`.

    """
    best = math.inf
    step_x, step_y = 0.0, 0.0
    for _ in range(MOST_STEPS):
        new_x, new_y = at_x + step_x, at_y + step_y
        if new_x * new_x + new_y * new_y < fold2:
            place_x, place_y, derivative = _distorted_inside(new_x, new_y, coefficients)
            error_x, error_y = x - place_x, y - place_y
            error = max(abs(error_x), abs(error_y))
            if error < best:
                at_x, at_y, best = new_x, new_y, error
                xx, xy, yx, yy = derivative
                determinant = xx * yy - xy * yx
                xx, xy, yx, yy = (
                    yy / determinant, -xy / determinant, -yx / determinant, xx / determinant
                )
                if error < CLOSE_ENOUGH:
                    return True, at_x, at_y, xx, xy, yx, yy
                step_x = xx * error_x + xy * error_y
                step_y = yx * error_x + yy * error_y
                continue
        step_x, step_y = 0.5 * step_x, 0.5 * step_y
    return False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@lru_cache(maxsize=8)
def _fold_radius(coefficients: Coefficients) -> float:
    """
    Return the least tan(angle to the axis) at which the picture turns back or runs to infinity.

    There the determinant of the derivative or the denominator of g changes its sign: beyond, two
    rays share a place, and only the one nearer to the axis is the lens'. Infinite where it does
    not happen within 89 degrees.
    """
    if not any(coefficients):
        return float('inf')
    k4, k5, k6 = _padded(coefficients)[5:8]
    phi = 2.0 * np.pi / DIRECTIONS * np.arange(DIRECTIONS)[:, None]

    def holds(radius: NDArray[np.float64]) -> NDArray[np.bool_]:
        with np.errstate(divide='ignore', invalid='ignore'):
            xx, xy, yx, yy = _distorted(
                radius * np.cos(phi), radius * np.sin(phi), _padded(coefficients)[:12]
            )[2]
        below = 1.0 + radius**2 * (k4 + radius**2 * (k5 + radius**2 * k6))
        return (xx * yy - xy * yx > 0.0) & (below > 0.0)

    radii = np.tan(np.radians(np.linspace(0.0, WIDEST_DEG, int(10 * WIDEST_DEG) + 1)))
    for _ in range(FINER):
        fails = ~holds(radii).all(axis=0)
        if not fails.any():
            return float('inf')
        first = int(np.argmax(fails))
        radii = np.linspace(radii[max(first - 1, 0)], radii[first], 101)
    return float(radii[0])


@lru_cache(maxsize=8)
def _tilt(coefficients: Coefficients) -> NDArray[np.float64] | None:
    """Return the (3, 3) homography from an upright to the tilted sensor; None for no tilt."""
    if len(coefficients) < COUNT or not any(coefficients[12:]):
        return None
    (cos_x, cos_y), (sin_x, sin_y) = np.cos(coefficients[12:]), np.sin(coefficients[12:])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cos_x, sin_x], [0.0, -sin_x, cos_x]])
    about_y = np.array([[cos_y, 0.0, -sin_y], [0.0, 1.0, 0.0], [sin_y, 0.0, cos_y]])
    turn = about_y @ about_x
    onto = np.array(
        [[turn[2, 2], 0.0, -turn[0, 2]], [0.0, turn[2, 2], -turn[1, 2]], [0.0, 0.0, 1.0]]
    )
    return np.asarray(onto @ turn)


def _untilted(
    x: float, y: float, tilt: NDArray[np.float64]
) -> tuple[float, float, tuple[float, float, float, float]]:
    """Return the place on an upright sensor, and its derivative by that on the tilted one."""
    (a, b, c), (d, e, f), (g, h, i) = np.linalg.inv(tilt).tolist()
    w = g * x + h * y + i
    u, v = (a * x + b * y + c) / w, (d * x + e * y + f) / w
    return u, v, ((a - g * u) / w, (b - h * u) / w, (d - g * v) / w, (e - h * v) / w)

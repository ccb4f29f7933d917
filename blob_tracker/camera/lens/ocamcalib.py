"""
The lens model ocamcalib, of OCamCalib's calib_results.txt: mirrors and fish-eyes.

The place (x, y) is that of a point (u, v) on an upright sensor behind a skewed one,

    x = u + e v,  y = d u + c v

and what is imaged there is the ray

    (u, v, 1 + a1 s + a2 s^2 + ...),  s = hypot(u, v)

(Scaramuzza, Martinelli and Siegwart, IROS 2006, eq. 3 and 5), in units of the polynomial's first
coefficient, which is the focal length. The coefficients are c d e a1 a2 ...
"""

from __future__ import annotations

from functools import lru_cache
from math import hypot
from typing import Any

from blob_tracker.camera.lens.definition import Coefficients, Derivative, Lens, Vector
from blob_tracker.camera.lens.numerical import projection, slopes
from blob_tracker.camera.lens.plumb_bob import start
import numpy as np
from numpy.typing import NDArray

UPRIGHT = (1.0, 0.0, 0.0)  # c d e
WIDEST = 20.0  # focal lengths from the centre, up to where a fold is looked for
LOOKS = 4000
HALVINGS = 64
MOST_POWERS = 12


def image(rays: NDArray[np.float64], coefficients: Coefficients) -> NDArray[np.float64]:
    """Image rays (N, 3) at places (N, 2), focal lengths; NaN for those past a fold."""
    (c, d, e), powers = _parts(coefficients)
    fold = _fold(powers)
    from_axis, z = np.hypot(rays[:, 0], rays[:, 1]), rays[:, 2]

    def short(s: NDArray[np.float64]) -> NDArray[np.bool_]:
        # The angle to the axis grows with s: the sine of what is left of it is above 0.
        return np.asarray(from_axis * _depth(s, powers)[0] - z * s > 0.0)

    low, high = np.zeros_like(z), np.full_like(z, fold)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        more = short(middle)
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    there = (np.arctan2(from_axis, z) < np.arctan2(fold, _depth(fold, powers)[0]))
    s = np.where(there, 0.5 * (low + high), np.nan)
    u, v = (s / np.where(from_axis > 0.0, from_axis, 1.0) * rays[:, :2].T)
    return np.column_stack([u + e * v, d * u + c * v])


def ray(x: float, y: float, coefficients: Coefficients) -> tuple[Vector, Derivative] | None:
    """Return the ray to a place; None beyond the fold."""
    (c, d, e), powers = _parts(coefficients)
    determinant = c - d * e
    u, v = (c * x - e * y) / determinant, (y - d * x) / determinant
    s = hypot(u, v)
    if not s < _fold(powers):
        return None
    z, slope = _depth(s, powers)
    along_u, along_v = (slope * u / s, slope * v / s) if s else (0.0, 0.0)
    u_x, u_y, v_x, v_y = c / determinant, -e / determinant, -d / determinant, 1.0 / determinant
    return (u, v, float(z)), (
        (u_x, u_y),
        (v_x, v_y),
        (float(along_u * u_x + along_v * v_x), float(along_u * u_y + along_v * v_y)),
    )


def _parts(coefficients: Coefficients) -> tuple[tuple[float, float, float], Coefficients]:
    """Return c, d, e and the powers of the polynomial."""
    c, d, e = coefficients[:3] or UPRIGHT
    return (c, d, e), coefficients[3:]


def _depth(s: NDArray[np.float64] | float, powers: Coefficients) -> tuple[Any, Any]:
    """Return Z of the ray at a distance from the centre, and its derivative."""
    value, slope = 0.0 * s, 0.0 * s
    for power in reversed((1.0, *powers)):
        slope = slope * s + value
        value = value * s + power
    return value, slope


@lru_cache(maxsize=8)
def _fold(powers: Coefficients) -> float:
    """Return the least s at which the angle to the axis no longer grows with it."""
    def grows(s: NDArray[np.float64] | float) -> NDArray[np.bool_]:
        z, slope = _depth(s, powers)
        return np.asarray(z - s * slope > 0.0)

    looks = np.linspace(0.0, WIDEST, LOOKS + 1)
    fails = np.flatnonzero(~grows(looks))
    if not fails.size:
        return WIDEST
    low, high = float(looks[max(fails[0] - 1, 0)]), float(looks[fails[0]])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if grows(middle) else (low, middle)
    return low


LENS = Lens(
    counts=(0, *range(4, 4 + MOST_POWERS)), image=image, ray=ray, names=(), start=start,
    project=projection(image), slopes=slopes(ray),
)

"""
The lens model eucm, the enhanced unified one, of wide lenses and fish-eyes.

A ray is imaged at

    (X, Y) / (alpha d + (1 - alpha) Z),  d = sqrt(beta (X^2 + Y^2) + Z^2)

(Khomutenko, Garcia and Martinet, IEEE Robotics and Automation Letters 1 (2016), eq. 5 to 13). A
beta of 1 is the unified model of Mei.
"""

from __future__ import annotations

from math import sqrt

from blob_tracker.camera.lens.definition import Coefficients, Derivative, Lens, Vector
from blob_tracker.camera.lens.numerical import projection, slopes
from blob_tracker.camera.lens.plumb_bob import start
from blob_tracker.camera.lens.radial import radial_ray
import numpy as np
from numpy.typing import NDArray


def image(rays: NDArray[np.float64], coefficients: Coefficients) -> NDArray[np.float64]:
    """Image rays (N, 3) at places (N, 2), focal lengths; NaN for those it has no picture of."""
    alpha, beta = coefficients or (0.0, 1.0)
    x, y, z = rays.T
    with np.errstate(divide='ignore', invalid='ignore'):
        distance = np.sqrt(beta * (x * x + y * y) + z * z)
        # Beyond, the picture runs back (alpha above 0.5) or past infinity.
        seen = z > -behind(alpha) * distance
        depth = np.where(seen, alpha * distance + (1.0 - alpha) * z, np.nan)
        return np.asarray(rays[:, :2] / depth[:, None])


def ray(x: float, y: float, coefficients: Coefficients) -> tuple[Vector, Derivative] | None:
    """Find the ray to a place, (x, y, Z); None beyond the rim of an alpha above 0.5."""
    alpha, beta = coefficients or (0.0, 1.0)
    along = depth(x * x + y * y, alpha, beta)
    return None if along is None else radial_ray(x, y, (1.0, 0.0), along)


def behind(alpha: float) -> float:
    """Return to which Z / d behind the lens there is a picture."""
    return alpha / (1.0 - alpha) if alpha <= 0.5 else (1.0 - alpha) / alpha


def depth(r2: float, alpha: float, beta: float) -> tuple[float, float] | None:
    """Return Z of the ray (x, y, Z) to a place with r^2, and its derivative by r^2."""
    inside = 1.0 - (2.0 * alpha - 1.0) * beta * r2
    if not inside > 0.0:
        return None
    root = sqrt(inside)
    below = alpha * root + 1.0 - alpha
    above = 1.0 - alpha * alpha * beta * r2
    below_slope = -0.5 * alpha * (2.0 * alpha - 1.0) * beta / root
    return above / below, (-alpha * alpha * beta * below - above * below_slope) / (below * below)


LENS = Lens(
    counts=(0, 2), image=image, ray=ray, names=(), start=start, project=projection(image),
    slopes=slopes(ray),
)

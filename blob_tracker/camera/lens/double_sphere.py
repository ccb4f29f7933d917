"""
The lens model double_sphere, of fish-eyes.

With w = Z + xi |(X, Y, Z)| a ray is imaged at

    (X, Y) / (alpha sqrt(X^2 + Y^2 + w^2) + (1 - alpha) w)

(Usenko, Demmel and Cremers, "The double sphere camera model", 3DV 2018, eq. 40 to 52).
"""

from __future__ import annotations

from math import sqrt

from blob_tracker.camera.lens.definition import Coefficients, Derivative, Lens, Vector
from blob_tracker.camera.lens.eucm import behind, depth
from blob_tracker.camera.lens.numerical import projection, slopes
from blob_tracker.camera.lens.plumb_bob import start
from blob_tracker.camera.lens.radial import radial_ray
import numpy as np
from numpy.typing import NDArray


def image(rays: NDArray[np.float64], coefficients: Coefficients) -> NDArray[np.float64]:
    """Image rays (N, 3) at places (N, 2), focal lengths; NaN for those it has no picture of."""
    xi, alpha = coefficients or (0.0, 0.0)
    x, y, z = rays.T
    with np.errstate(divide='ignore', invalid='ignore'):
        length = np.sqrt(x * x + y * y + z * z)
        shifted = xi * length + z
        w1 = behind(alpha)
        w2 = (w1 + xi) / np.sqrt(2.0 * w1 * xi + xi * xi + 1.0)
        ahead = alpha * np.sqrt(x * x + y * y + shifted * shifted) + (1.0 - alpha) * shifted
        return np.asarray(rays[:, :2] / np.where(z > -w2 * length, ahead, np.nan)[:, None])


def ray(x: float, y: float, coefficients: Coefficients) -> tuple[Vector, Derivative] | None:
    """Return k (x, y, m) - (0, 0, xi), the point of the first sphere that is imaged at a place."""
    xi, alpha = coefficients or (0.0, 0.0)
    r2 = x * x + y * y
    second = depth(r2, alpha, 1.0)
    if second is None:
        return None
    m, m_slope = second
    inside = m * m + (1.0 - xi * xi) * r2
    if not inside > 0.0:
        return None
    root, below = sqrt(inside), m * m + r2
    k = (m * xi + root) / below
    turn = 2.0 * m * m_slope
    k_slope = (m_slope * xi + 0.5 * (turn + 1.0 - xi * xi) / root - k * (turn + 1.0)) / below
    return radial_ray(x, y, (k, k_slope), (k * m - xi, k_slope * m + k * m_slope))


LENS = Lens(
    counts=(0, 2), image=image, ray=ray, names=(), start=start, project=projection(image),
    slopes=slopes(ray),
)

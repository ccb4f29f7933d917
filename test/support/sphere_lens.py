"""The unified sphere model, of mirrors and fish-eyes: a lens that the registry does not have."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

from blob_tracker.camera.lens import plumb_bob
from blob_tracker.camera.lens.definition import Coefficients, Derivative, Lens, Start, Vector
from blob_tracker.camera.lens.numerical import projection, slopes
import numpy as np
from numpy.typing import NDArray


def image(rays: NDArray[np.float64], coefficients: Coefficients) -> NDArray[np.float64]:
    """Image unit rays at (X, Y) / (Z + xi) (Mei and Rives, ICRA 2007, eq. 1 to 4)."""
    (xi,) = coefficients or (0.0,)
    unit = rays / np.linalg.norm(rays, axis=1)[:, None]
    depth = np.where(unit[:, 2] + xi > 0.0, unit[:, 2] + xi, np.nan)
    return np.asarray(unit[:, :2] / depth[:, None])


def ray(x: float, y: float, coefficients: Coefficients) -> tuple[Vector, Derivative] | None:
    """Return eta (x, y, 1) - (0, 0, xi), the point of the sphere that is imaged at a place."""
    (xi,) = coefficients or (0.0,)
    r2 = x * x + y * y
    inside = 1.0 + (1.0 - xi * xi) * r2
    if inside < 0.0:
        return None
    root = sqrt(inside)
    eta = (xi + root) / (1.0 + r2)
    slope = (0.5 * (1.0 - xi * xi) / root - eta) / (1.0 + r2)  # d eta / d r^2
    return (eta * x, eta * y, eta - xi), (
        (eta + 2.0 * x * x * slope, 2.0 * x * y * slope),
        (2.0 * x * y * slope, eta + 2.0 * y * y * slope),
        (2.0 * x * slope, 2.0 * y * slope),
    )


def start(
    points: Sequence[NDArray[np.float64]],
    places: Sequence[NDArray[np.float64]],
    size: tuple[int, int],
) -> Start:
    """Begin with a pinhole, which is a xi of 0."""
    return plumb_bob.start(points, places, size)._replace(coefficients=np.zeros(1))


LENS = Lens(
    counts=(0, 1), image=image, ray=ray, names=('xi',), start=start, project=projection(image),
    slopes=slopes(ray), sigmas=(inf,),
)

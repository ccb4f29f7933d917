"""Lens distortion, both ways and with its derivative, by OpenCV's own models."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

# ROS' name of the model: the numbers of coefficients it may have.
DISTORTION_MODELS = {
    '': (0,),
    'plumb_bob': (0, 4, 5),
    'rational_polynomial': (0, 8, 12, 14),
}
MAX_ITERATIONS = 20
CLOSE_ENOUGH = 1e-10  # px


class LensError(ValueError):
    """A pixel to which no ray of the lens model leads."""


def project(
    ray: NDArray[np.float64], matrix: NDArray[np.float64], distortion: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Image the ray (x, y, 1).

    Parameters
    ----------
    ray : (2,) array
        Normalised image coordinates X / Z and Y / Z.
    matrix : (3, 3) array
        Camera matrix K, px.
    distortion : (n,) array
        Coefficients in OpenCV's order k1 k2 p1 p2 k3 ...

    Returns
    -------
    (2,) array, (2, 2) array
        Pixel, and its derivative by the normalised coordinates, px.

    """
    origin = np.zeros(3)
    point = np.array([[ray[0], ray[1], 1.0]])
    pixel, jacobian = cv2.projectPoints(point, origin, origin, matrix, distortion)
    # At unit depth, moving the point is moving the ray: columns 3 and 4 are d pixel / d (X, Y).
    # OpenCV leaves out the skew K[0, 1].
    derivative = jacobian[:, 3:5].copy()
    pixel = pixel.reshape(2)
    slant = matrix[0, 1] / matrix[1, 1]
    derivative[0] += slant * derivative[1]
    return np.array([pixel[0] + slant * (pixel[1] - matrix[1, 2]), pixel[1]]), derivative


def unproject(
    pixel: NDArray[np.float64], matrix: NDArray[np.float64], distortion: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Find the ray (x, y, 1) that is imaged on a pixel.

    Exact without distortion; with it, Newton's iteration on `project` down to 1e-10 px.

    Parameters
    ----------
    pixel : (2,) array
        px.
    matrix : (3, 3) array
        Camera matrix K, px.
    distortion : (n,) array
        Coefficients in OpenCV's order.

    Returns
    -------
    (2,) array, (2, 2) array
        Normalised coordinates, and their derivative by the pixel, 1/px.

    Raises
    ------
    LensError
        Where the iteration does not end: the pixel lies where the distortion model folds over.

    """
    inverse = np.asarray(np.linalg.inv(matrix[:2, :2]), dtype=np.float64)
    ray = inverse @ (pixel - matrix[:2, 2])
    if not distortion.any():
        return ray, inverse
    fold = _fold_radius(tuple(distortion.tolist()))
    for _ in range(MAX_ITERATIONS):
        imaged, derivative = project(ray, matrix, distortion)
        try:
            inverse = np.asarray(np.linalg.inv(derivative), dtype=np.float64)
        except np.linalg.LinAlgError:
            break
        error = pixel - imaged
        if np.abs(error).max() < CLOSE_ENOUGH:
            if np.hypot(*ray) >= fold:
                break  # a second ray onto this pixel, from beyond where the model turns back
            return ray, inverse
        ray = ray + inverse @ error
    raise LensError(
        f'no ray leads to the pixel ({pixel[0]:.1f}, {pixel[1]:.1f}): '
        'the distortion coefficients do not hold there'
    )


@lru_cache(maxsize=8)
def _fold_radius(distortion: tuple[float, ...]) -> float:
    """
    Return the least tan(angle to the axis) at which the distorted picture turns back.

    There the derivative's determinant changes sign: beyond it two rays share a pixel, and only
    the one nearer to the axis is the lens'. Infinite where it does not happen within 89 degrees.
    """
    radii = np.tan(np.radians(np.linspace(0.0, 89.0, 891)))[1:]
    first = np.inf
    for direction in np.arange(8) * np.pi / 4:
        for radius in radii[radii < first]:
            ray = radius * np.array([np.cos(direction), np.sin(direction)])
            if np.linalg.det(project(ray, np.eye(3), np.array(distortion))[1]) <= 0.0:
                first = float(radius)
                break
    return first

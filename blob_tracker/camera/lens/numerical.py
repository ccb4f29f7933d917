"""What a fit and the lab need of a lens that no library has, from `image` and `ray` alone."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.camera.lens.definition import Coefficients, Derivative, Projection, Vector
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 1e-6  # of a parameter, or in its unit where it is below 1: rounding and bend are 1e-9 each


def projection(
    image: Callable[[Array, Coefficients], Array],
) -> Callable[[Array, Array, Array, Array, Array], Projection]:
    """
    Return `Lens.project` of an `image`, with central differences for derivatives.

    Parameters
    ----------
    image : callable
        As `Lens.image`.

    """

    def project(
        points: Array, rotation: Array, translation: Array, matrix: Array, coefficients: Array
    ) -> Projection:
        import cv2

        def places(parameters: Array) -> Array:
            (fx, fy, cx, cy), own = parameters[:4], parameters[4:-6]
            turn = cv2.Rodrigues(parameters[-6:-3])[0]
            rays = points @ turn.T + parameters[-3:]
            return np.asarray(image(rays, tuple(own.tolist())) * (fx, fy) + (cx, cy))

        at = np.concatenate([
            matrix[[0, 1, 0, 1], [0, 1, 2, 2]], coefficients, np.ravel(rotation),
            np.ravel(translation),
        ])
        derivative = np.empty((2 * len(points), len(at)))
        for column, value in enumerate(at):
            step = np.zeros(len(at))
            step[column] = STEP * max(1.0, abs(value))
            difference = places(at + step) - places(at - step)
            derivative[:, column] = difference.ravel() / (2.0 * step[column])
        return Projection(places(at), derivative[:, :-6], derivative[:, -6:])

    return project


def slopes(
    ray: Callable[[float, float, Coefficients], tuple[Vector, Derivative] | None],
) -> Callable[[Array, Array, Array], Array]:
    """
    Return `Lens.slopes` of a `ray`, one place after the other: NaN if there is no ray.

    Parameters
    ----------
    ray : callable
        As `Lens.ray`.

    """

    def found(places: Array, matrix: Array, coefficients: Array) -> Array:
        values = tuple(np.ravel(coefficients).tolist())
        ideal = (places - matrix[:2, 2]) @ np.linalg.inv(matrix[:2, :2]).T
        rays = np.full((len(places), 3), np.nan)
        for row, (x, y) in enumerate(ideal.tolist()):
            there = ray(x, y, values)
            if there is not None:
                rays[row] = there[0]
        return np.asarray(rays[:, :2] / rays[:, 2:])

    return found

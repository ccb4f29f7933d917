"""What a lens model is: the way from a ray to its place in the picture, and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Coefficients = tuple[float, ...]
Vector = tuple[float, float, float]
# d ray / d place, by rows X, Y, Z.
Derivative = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


class LensError(ValueError):
    """A pixel to which no ray of the lens model leads, or none that has an azimuth."""


@dataclass(frozen=True)
class Lens:
    """
    A lens model in units of the focal length, before the camera matrix makes pixels of it.

    Parameters
    ----------
    counts : tuple of int
        The numbers of coefficients that it may have.
    image : callable
        image(rays (N, 3), coefficients) -> places (N, 2), NaN where it has no picture of a ray.
    ray : callable
        ray(x, y, coefficients) -> a ray (X, Y, Z) that is imaged at that place, and its
        derivative by x and y; None where there is no such ray. It is on the way of each frame:
        scalars, since arrays of three cost ten times as much.

    """

    counts: tuple[int, ...]
    image: Callable[[NDArray[np.float64], Coefficients], NDArray[np.float64]]
    ray: Callable[[float, float, Coefficients], tuple[Vector, Derivative] | None]

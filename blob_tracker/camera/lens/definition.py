"""What a lens model is: the way from a ray to its place in the picture, and back, and its fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Coefficients = tuple[float, ...]
Vector = tuple[float, float, float]
# d ray / d place, by rows X, Y, Z.
Derivative = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


class LensError(ValueError):
    """
    A pixel to which no ray of the lens model leads, or none that has an azimuth.

    Examples
    --------
    A strong barrel distortion, by which no ray leads to the corner of the picture:

    >>> from blob_tracker.camera import CameraModel, pinhole_matrix
    >>> model = CameraModel(
    ...     640, 480, pinhole_matrix(600.0, 640, 480), np.array([-0.8, 0.0, 0.0, 0.0, 0.0])
    ... )
    >>> model.unproject(0.0, 0.0)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.camera.lens.definition.LensError: no ray leads to the pixel (0.0, 0.0): ...

    """


class Start(NamedTuple):
    """
    A camera and the poses of a board, as a fit of its views begins.

    Parameters
    ----------
    matrix : (3, 3) array
        K, px.
    coefficients : (n,) array
        As many as the lens has names for.
    rotations, translations : (M, 3) arrays
        Of the board in each view: rotation vector, rad, and place of its origin, mm.

    """

    matrix: Array
    coefficients: Array
    rotations: Array
    translations: Array


class Projection(NamedTuple):
    """
    The places of N points in the picture, with their derivatives.

    Parameters
    ----------
    places : (N, 2) array
        px.
    by_camera : (2 N, 4 + n) array
        By fx, fy, cx, cy and the coefficients.
    by_pose : (2 N, 6) array
        By the rotation vector, rad, and the translation, mm.

    """

    places: Array
    by_camera: Array
    by_pose: Array


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
        derivative by x and y; None if there is no such ray. It is on the way of each frame:
        scalars, since arrays of three cost ten times as much.
    names : tuple of str
        Of the coefficients that views of a board tell, in their order.
    start : callable
        start(points, places, (width, height)) -> `Start`: from the points (N, 3) of each view,
        mm, and their places (N, 2), px.
    project : callable
        project(points (N, 3), rotation (3,), translation (3,), K, coefficients) -> `Projection`.
    slopes : callable
        slopes(places (N, 2), K, coefficients) -> (N, 2): X / Z and Y / Z of the rays to many
        places at once, px, in front of the lens.
    sigmas : tuple of float
        Of each of `names`: to how much of a spread about 0 the fit holds it, infinite where it
        is free. Empty where `start` is the least sum of squares already: nothing is left to fit.
    former_names : tuple of str
        What some releases of ROS call it.

    """

    counts: tuple[int, ...]
    image: Callable[[Array, Coefficients], Array]
    ray: Callable[[float, float, Coefficients], tuple[Vector, Derivative] | None]
    names: tuple[str, ...]
    start: Callable[[Sequence[Array], Sequence[Array], tuple[int, int]], Start]
    project: Callable[[Array, Array, Array, Array, Array], Projection]
    slopes: Callable[[Array, Array, Array], Array]
    sigmas: tuple[float, ...] = ()
    former_names: tuple[str, ...] = ()

"""Rays of lenses whose picture is one turned about the axis, with their derivative."""

from __future__ import annotations

from blob_tracker.camera.lens.definition import Derivative, Vector


def radial_ray(
    x: float, y: float, across: tuple[float, float], along: tuple[float, float]
) -> tuple[Vector, Derivative]:
    """
    Return the ray (a x, a y, b) to a place, where a and b hang on r^2 = x^2 + y^2 alone.

    Parameters
    ----------
    x, y : float
        The place, focal lengths.
    across, along : (float, float)
        a and b, each with its derivative by r^2.

    """
    a, a_slope = across
    b, b_slope = along
    mixed = 2.0 * x * y * a_slope
    return (a * x, a * y, b), (
        (a + 2.0 * x * x * a_slope, mixed),
        (mixed, a + 2.0 * y * y * a_slope),
        (2.0 * x * b_slope, 2.0 * y * b_slope),
    )

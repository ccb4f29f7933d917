"""
The corner where four squares meet, placed by the picture that a lens makes of it.

Two edges through the corner c, each blurred by a Gaussian of sigma s, give the signal

    b + a erf(n1 . (p - c) / (sqrt2 s)) erf(n2 . (p - c) / (sqrt2 s))

with n1, n2 across the edges: seven parameters, fitted to the pixels about the corner by least
squares. On rendered boards it stays four times nearer to the truth than cv2.cornerSubPix, whose
gradients are biased by the pixels.
"""

from __future__ import annotations

from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

STEPS = 12  # of the fit: the last moves a corner by less than 1e-4 px
FIRST_BLUR = 0.8  # px
DAMPING = 1e-3
LONGEST_STEP = (1.0, 1.0, 0.2, 0.2, np.inf, np.inf, 0.5)  # px, px, rad, rad, DN, DN, log px
LEAST_RADIUS = 2  # px: fewer pixels do not tell seven parameters
MOST_RADIUS = 12  # px: farther out the edges of a distorted picture are no straight lines

Array = NDArray[np.float64]


def place_saddles(
    image: Pixels, places: Array, edges: Array, radius: float
) -> tuple[Array, NDArray[np.bool_]]:
    """
    Place corners to a small part of a pixel.

    Parameters
    ----------
    image : (h, w) array
        DN.
    places : (N, 2) array
        Where the corners are to about a pixel.
    edges : (N, 2) array
        Direction of the two edges through each, rad, to about 0.3.
    radius : float
        How far from a corner nothing but its four squares is seen, px.

    Returns
    -------
    (N, 2) array, (N,) array of bool
        px, and whether a corner was placed: not where it is too near to the border, or where
        the fit runs away.

    """
    reach = int(np.clip(radius, LEAST_RADIUS, MOST_RADIUS))
    height, width = image.shape
    whole = np.rint(places).astype(int)
    last = np.array([width, height]) - reach
    inside = np.asarray(((whole >= reach) & (whole < last)).all(axis=1), dtype=np.bool_)
    placed = places.copy()
    if not inside.any():
        return placed, inside
    across = np.arange(-reach, reach + 1)
    x, y = (side.ravel() for side in np.meshgrid(across, across))
    round_ = np.hypot(x, y) <= reach + 0.5
    x, y = x[round_], y[round_]
    pixels = image[whole[inside, 1, None] + y, whole[inside, 0, None] + x].astype(float)
    start = places[inside] - whole[inside]
    found = _fit(pixels, x.astype(float), y.astype(float), start, edges[inside])
    good = np.isfinite(found).all(axis=1) & (np.abs(found - start).max(axis=1) < reach)
    placed[inside] = np.where(good[:, None], whole[inside] + found, placed[inside])
    inside[inside] = good
    return placed, inside


def _fit(pixels: Array, x: Array, y: Array, start: Array, edges: Array) -> Array:
    """Return the corners (N, 2) relative to the middle pixel, by damped Gauss-Newton steps."""
    count = len(pixels)
    theta = np.empty((count, 7))
    theta[:, :2], theta[:, 2:4] = start, edges
    theta[:, 4], theta[:, 5], theta[:, 6] = pixels.mean(axis=1), 1.0, np.log(FIRST_BLUR)
    shape = _signal(theta, x, y)[0] - theta[:, 4:5]
    theta[:, 5] = (shape * (pixels - theta[:, 4:5])).sum(axis=1) / (shape**2).sum(axis=1)
    diagonal = np.arange(7)
    limit = np.array(LONGEST_STEP)
    for _ in range(STEPS):
        signal, jacobian = _signal(theta, x, y)
        transposed = jacobian.transpose(0, 2, 1)
        normal = transposed @ jacobian
        normal[:, diagonal, diagonal] *= 1.0 + DAMPING
        normal[:, diagonal, diagonal] += 1e-12  # a window without contrast has no solution
        step = np.linalg.solve(normal, transposed @ (pixels - signal)[..., None])[..., 0]
        theta += np.clip(step, -limit, limit)
    return theta[:, :2]


def _signal(theta: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Return the signal (N, pixels) and its derivative by the parameters (N, pixels, 7)."""
    corner_x, corner_y, *angles, background, contrast, log_blur = theta.T[..., None]
    scale = np.sqrt(2.0) * np.exp(np.clip(log_blur, -3.0, 3.0))
    dx, dy = x - corner_x, y - corner_y
    values, slopes, alongs = [], [], []
    for angle in angles:
        distance = (np.cos(angle) * dy - np.sin(angle) * dx) / scale
        values.append(erf(distance))
        slopes.append(2.0 / np.sqrt(np.pi) * np.exp(-(distance**2)))
        alongs.append((distance, np.cos(angle) * dx + np.sin(angle) * dy))
    by_first = contrast * slopes[0] * values[1]
    by_second = contrast * slopes[1] * values[0]
    jacobian = np.stack(
        [
            (by_first * np.sin(angles[0]) + by_second * np.sin(angles[1])) / scale,
            -(by_first * np.cos(angles[0]) + by_second * np.cos(angles[1])) / scale,
            -by_first * alongs[0][1] / scale,
            -by_second * alongs[1][1] / scale,
            np.ones_like(dx),
            values[0] * values[1],
            -(by_first * alongs[0][0] + by_second * alongs[1][0]),
        ],
        axis=-1,
    )
    return background + contrast * values[0] * values[1], jacobian

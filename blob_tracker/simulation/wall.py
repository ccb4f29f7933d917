"""What stands behind everything: a wall with a texture of many sizes."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SCALES_PX = (1.0, 4.0, 16.0)  # px, standard deviations of the blurs that make the pattern


def textured_wall(
    shape: tuple[int, int],
    *,
    background: float,
    texture: float,
    seed: int,
    pitch: float = 1.0,
) -> NDArray[np.float32]:
    """
    Return the mean signal of a wall: pattern of 1 to 16 px on a slope.

    Parameters
    ----------
    shape : (int, int)
        Height and width of the array.
    background, texture : float
        Mean of the wall and standard deviation of its pattern, DN.
    seed : int
        Of the pattern.
    pitch : float
        Elements of the array to a pixel of the picture.

    Returns
    -------
    (h, w) array
        DN, 0 or more.

    """
    random = np.random.default_rng([seed, 0])
    pattern = np.zeros(shape, dtype=np.float32)
    for scale in SCALES_PX:
        white = random.standard_normal(shape, dtype=np.float32)
        layer = np.asarray(cv2.GaussianBlur(white, (0, 0), pitch * scale))
        pattern += layer / layer.std()
    slope = np.linspace(-0.5, 0.5, shape[1], dtype=np.float32)
    wall = background * (1.0 + 0.5 * slope) + texture * pattern / np.sqrt(3.0)
    return np.maximum(wall, 0.0).astype(np.float32)

"""
How far the centroid of a dot's picture lies from the picture of its centre.

Perspective draws the near half of a tilted disc larger than the far half, and distortion bends
its rim: the centroid moves by about f tilt (radius / distance)^2, a tenth of a pixel or more.
With the camera and the pose known it is computed, not estimated (Heikkila, IEEE Trans. PAMI 22
(2000) 1066, which gives the closed form without distortion).
"""

from __future__ import annotations

from blob_tracker.camera import CameraModel
import cv2
import numpy as np
from numpy.typing import NDArray

RIM = 64  # points of a disc's rim: the polygon's centroid is true to 1e-4 of the offset
Array = NDArray[np.float64]


def centre_offsets(
    points: Array, diameter: float, rotation: Array, translation: Array, model: CameraModel
) -> Array:
    """
    Return the centroid of each dot's picture less the picture of its centre.

    Parameters
    ----------
    points : (N, 2) array
        Centres of the dots, mm.
    diameter : float
        Of the dots, mm.
    rotation, translation : (3,) array
        Of the board.
    model : CameraModel
        The camera.

    Returns
    -------
    (N, 2) array
        px.

    """
    turn = np.linspace(0.0, 2.0 * np.pi, RIM, endpoint=False)
    rim = 0.5 * diameter * np.column_stack([np.cos(turn), np.sin(turn)])
    on_board = np.concatenate([points[:, None], points[:, None] + rim], axis=1)
    flat = np.concatenate([on_board, np.zeros((*on_board.shape[:2], 1))], axis=2).reshape(-1, 3)
    rays = flat @ cv2.Rodrigues(rotation)[0].T + translation
    places = model.project(rays).reshape(len(points), RIM + 1, 2)
    # About the centre, so that the products below stay small.
    x, y = np.moveaxis(places[:, 1:] - places[:, :1], -1, 0)
    next_x, next_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    area = x * next_y - next_x * y
    moments = np.stack([((x + next_x) * area).sum(1), ((y + next_y) * area).sum(1)], axis=-1)
    return np.asarray(moments / (3.0 * area.sum(axis=1))[:, None])

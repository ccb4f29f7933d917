"""The loops over pixels of this room, compiled before a pair of frames needs them."""

from __future__ import annotations

from blob_tracker.segmentation.registration.affine import affine
from blob_tracker.segmentation.registration.warp import warped
import numpy as np

SIDE_PX = 96
HALF_A_PIXEL = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5]])


def compile_registration() -> None:
    """Compile them, or load them from Numba's cache."""
    texture = np.random.default_rng(1).integers(0, 256, (SIDE_PX, SIDE_PX))
    for kind in (np.uint8, np.uint16):
        picture = texture.astype(kind)
        affine(picture, picture)
        warped(picture, picture, HALF_A_PIXEL)

"""Lay the unlit frame over the lit one, for a camera that moves between the two."""

from collections.abc import Callable

from blob_tracker.segmentation.registration.affine import affine
from blob_tracker.segmentation.registration.compiled import compile_registration
from blob_tracker.segmentation.registration.translation import translation
from blob_tracker.segmentation.registration.warp import overlap, warped
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

REGISTRATIONS: dict[str, Callable[[Pixels, Pixels], NDArray[np.float64] | None] | None] = {
    'none': None,
    'translation': translation,
    'affine': affine,
}

__all__ = [
    'affine', 'compile_registration', 'overlap', 'REGISTRATIONS', 'translation', 'warped',
]

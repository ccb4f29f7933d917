"""A camera whose picture shifts, turns, shears and grows between the unlit and the lit frame."""

from __future__ import annotations

from blob_tracker.segmentation.registration.alignment import align
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray


def affine(lit: Pixels, unlit: Pixels) -> NDArray[np.float64] | None:
    """
    Return the (2, 3) map from places in the unlit frame to places in the lit one: affine.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.

    Returns
    -------
    (2, 3) array or None
        px; None if the frames have too little in common, see `align`.

    """
    return align(lit, unlit, affine=True)

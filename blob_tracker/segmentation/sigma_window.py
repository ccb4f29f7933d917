"""A window of so many standard deviations about the blob, sized by its second moments."""

from __future__ import annotations

import math

from blob_tracker.kernel import kernel
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
import numpy as np

SMALLEST_HALF_PX = 3  # px: 7 x 7 hold a blob of sigma 1 and its background


def sigma_window(
    contrast: Contrast, candidate: Candidate, largest: int, *, sigmas: float
) -> Box | None:
    """
    Return the box of +-k sigma about a blob, re-centred on it.

    The thesis finds that the location is best from pixels within two of its s, 2.8 sigma, of the
    mean (sections 3.6 and 5.3).

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    candidate : Candidate
        What lit up, as its adaptive moments have it.
    largest : int
        Greatest half-width of the box, px.
    sigmas : float
        k.

    Returns
    -------
    Box or None
        In the frame, 7 x 7 px or more but for what the frame's border cuts off. None if the
        blob would not fit into `largest`.

    """
    height, width = contrast.lit.shape
    box = about(
        candidate.x, candidate.y, sigmas * candidate.sigma_x, sigmas * candidate.sigma_y, largest,
        width, height,
    )
    return Box(*box) if box[0] < box[2] else None


@kernel
def about(
    x: float, y: float, reach_x: float, reach_y: float, largest: int, width: int, height: int
) -> tuple[int, int, int, int]:
    """Return the edges of the box so far about a place; an empty one where it is too large."""
    half_x = max(int(math.ceil(reach_x)), SMALLEST_HALF_PX)
    half_y = max(int(math.ceil(reach_y)), SMALLEST_HALF_PX)
    if max(half_x, half_y) > largest:
        return 0, 0, 0, 0
    column, row = int(np.rint(x)), int(np.rint(y))
    return (
        max(column - half_x, 0), max(row - half_y, 0),
        min(column + half_x + 1, width), min(row + half_y + 1, height),
    )

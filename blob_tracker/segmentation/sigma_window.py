"""A window of so many standard deviations about the blob, sized by its second moments."""

from __future__ import annotations

import math

from blob_tracker.segmentation.box import Box, box_about
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast

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
        In the frame, 7 x 7 px or more but for what the frame's border cuts off. None where the
        blob would not fit into `largest`.

    """
    half_x = max(math.ceil(sigmas * candidate.sigma_x), SMALLEST_HALF_PX)
    half_y = max(math.ceil(sigmas * candidate.sigma_y), SMALLEST_HALF_PX)
    if half_x > largest or half_y > largest:
        return None
    return box_about(round(candidate.x), round(candidate.y), half_x, half_y, contrast.shape)

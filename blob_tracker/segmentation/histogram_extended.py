"""The histogram's window and some pixels about it, for the tails (thesis, section 5.3)."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.histogram import histogram


def histogram_extended(
    contrast: Contrast, candidate: Candidate, largest: int, *, extension: int
) -> Box | None:
    """
    Return the box of `histogram`, grown on all four sides.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    candidate : Candidate
        What lit up.
    largest : int
        Half the width of the region whose histogram is taken, px.
    extension : int
        Pixels added on each side, but for what the frame's border cuts off.

    Returns
    -------
    Box or None
        In the frame, px. None if `histogram` finds none.

    """
    box = histogram(contrast, candidate, largest)
    if box is None:
        return None
    height, width = contrast.shape
    return Box(
        max(box.x0 - extension, 0),
        max(box.y0 - extension, 0),
        min(box.x1 + extension, width),
        min(box.y1 + extension, height),
    )

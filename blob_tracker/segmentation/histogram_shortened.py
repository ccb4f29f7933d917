"""The histogram's window without the trailing edge of the blob (thesis, section 5.3)."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.histogram import histogram


def histogram_shortened(
    contrast: Contrast, candidate: Candidate, largest: int
) -> Box | None:
    """
    Return the box of `histogram`, its right side one pixel beyond the peak.

    For cameras and frame grabbers whose signal drops too fast after a bright pixel (thesis,
    fig. 5.3): the trailing edge of the blob is false and is left out.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    candidate : Candidate
        What lit up.
    largest : int
        Half the width of the region whose histogram is taken, px.

    Returns
    -------
    Box or None
        In the frame, px. None if `histogram` finds none.

    """
    box = histogram(contrast, candidate, largest)
    return None if box is None else box._replace(x1=min(box.x1, candidate.peak[0] + 2))

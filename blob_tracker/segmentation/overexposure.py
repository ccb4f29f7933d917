"""Say of what is too bright for its shape to be known what to do about it."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.box import box_about
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
import numpy as np

REACH_SIGMA = 3.0  # sigma of a blob, within which clipped pixels are its own
# Pixels: as many hold a blob of which only the flanks are left; one or two say nothing of a shape.
LEAST_PIXELS = 3


def with_clipping(contrast: Contrast, candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """
    Return the candidates, with the advice to expose less in why over-exposed ones are rejected.

    Charge that runs along a column, glare and a flat top make a shape of a light that is none of a
    blob: it is a matter of the exposure, unless the pixels were clipped before.
    """
    out = []
    for each in candidates:
        if each.rejected and not each.clipped and _is_newly_clipped(contrast, each):
            column, row = each.peak
            reach = max(round(REACH_SIGMA * each.sigma_major), 3)
            about = box_about(column, row, reach, reach, contrast.shape).slices
            count = int(np.count_nonzero(contrast.lit[about] >= contrast.saturation))
            if count >= LEAST_PIXELS:
                each = each._replace(
                    rejected=f'{count} pixels are clipped: lower the exposure; as it is, '
                    + each.rejected
                )
        out.append(each)
    return tuple(out)


def _is_newly_clipped(contrast: Contrast, candidate: Candidate) -> bool:
    """Tell whether the peak is clipped, and was not before."""
    column, row = candidate.peak
    lit, unlit = contrast.lit[row, column], contrast.unlit[row, column]
    return bool(lit >= contrast.saturation > unlit)

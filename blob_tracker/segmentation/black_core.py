"""A light so bright that the sensor reads black in its midst."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.box import box_about
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.types import Pixels
import numpy as np

REACH_PX = 48  # px from a clipped peak, within which the rim about the core is closed
MOST_PLACES = 8  # clipped peaks that are looked at: a light has few, and the sun's rim has many
# Of full scale: the rim is brighter, and the core darker. A rim that is thinner than a pixel has
# gaps, where the flank begins; a ring out of focus has a slope down to its hole, and no such step.
RIM_FRACTION, DARK_FRACTION = 0.35, 0.2
CLIPPED_FRACTION = 0.125  # of the rim
NEIGHBOURS = np.ones((3, 3), np.uint8)


def without_black_cores(contrast: Contrast, candidates: Sequence[Candidate]) -> Contrast | None:
    """
    Return the contrast with the core of each light as it should be: clipped.

    Far beyond full scale some sensors read black (the reset level that is subtracted has caught
    light as well), and some readouts wrap round. What is enclosed by clipped pixels is brighter
    than they are: it becomes full scale, which the location leaves out.

    Parameters
    ----------
    contrast : Contrast
        Of a raw lit frame.
    candidates : sequence of Candidate
        What lit up in it.

    Returns
    -------
    Contrast or None
        With another lit frame; None if nothing is enclosed.

    """
    if not candidates or len(contrast.lit_frames) != 1:
        return None
    image, saturation = contrast.lit, contrast.saturation
    pixel = image.item
    reached = [
        each for each in candidates if pixel(int(each.row), int(each.column)) >= saturation
    ]
    if not reached:
        return None
    import cv2  # no part of a start

    filled: Pixels | None = None
    seen: list[tuple[int, int, int, int]] = []
    for each in reached:
        column, row = each.peak
        if any(x0 <= column < x1 and y0 <= row < y1 for x0, y0, x1, y1 in seen):
            continue
        box = box_about(column, row, REACH_PX, REACH_PX, contrast.shape)
        part = image[box.slices]
        bright = (part >= RIM_FRACTION * saturation).view(np.uint8)
        # Through edges only: the diagonal steps of a rim hold tight.
        count, labels = cv2.connectedComponents(1 - bright, connectivity=4)
        border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
        for label in np.setdiff1d(np.arange(1, count), border):
            core = labels == label
            rim = cv2.dilate(core.view(np.uint8), NEIGHBOURS).view(bool) & ~core
            clipped = np.count_nonzero(part[rim] >= saturation)
            if (
                clipped >= CLIPPED_FRACTION * np.count_nonzero(rim)
                and np.median(part[core]) < DARK_FRACTION * saturation
            ):
                filled = image.copy() if filled is None else filled
                filled[box.slices][core] = saturation
        seen.append(box)
        if len(seen) == MOST_PLACES:
            break
    if filled is None:
        return None
    return contrast._replace(lit=filled, lit_frames=(filled,))

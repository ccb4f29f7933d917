"""A light so bright that the sensor reads black in its midst."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.box import box_about
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import table_of
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.rejection import COLUMN, ROW
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

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
    reached = clipped_peaks(image, saturation, table_of(candidates)).tolist()
    if not reached:
        return None
    import cv2  # no part of a start

    filled: Pixels | None = None
    seen: list[tuple[int, int, int, int]] = []
    for column, row in reached:
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


@kernel
def clipped_peaks(image: Pixels, saturation: int, table: Array) -> NDArray[np.int64]:
    """Return (n, 2) columns and rows of the peaks that are clipped, in the table's order."""
    peaks = np.empty((table.shape[0], 2), np.int64)
    count = 0
    for k in range(table.shape[0]):
        column, row = int(table[k, COLUMN]), int(table[k, ROW])
        if image[row, column] >= saturation:
            peaks[count, 0], peaks[count, 1] = column, row
            count += 1
    return peaks[:count]

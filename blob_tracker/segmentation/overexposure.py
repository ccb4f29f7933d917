"""Say of what is too bright for its shape to be known what to do about it."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.box import box_about
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.rejection import COLUMN, FIELDS, MAJOR, NOTHING, ROW, WAS_CLIPPED
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

REACH_SIGMA = 3.0  # sigma of a blob, within which clipped pixels are its own
# Pixels: as many hold a blob of which only the flanks are left; one or two say nothing of a shape.
LEAST_PIXELS = 3


def clipped_pixels(contrast: Contrast, table: Array) -> dict[int, int]:
    """
    Return how many pixels of what is rejected are clipped, by its row in the table, if any are.

    Charge that runs along a column, glare and a flat top make a shape of a light that is none of a
    blob: it is a matter of the exposure, unless the pixels were clipped before.
    """
    counts = {}
    for index in newly_clipped(contrast.lit, contrast.unlit, contrast.saturation, table).tolist():
        column, row = int(table.item(index, COLUMN)), int(table.item(index, ROW))
        reach = max(round(REACH_SIGMA * table.item(index, MAJOR)), 3)
        about = box_about(column, row, reach, reach, contrast.shape).slices
        count = int(np.count_nonzero(contrast.lit[about] >= contrast.saturation))
        if count >= LEAST_PIXELS:
            counts[index] = count
    return counts


def advice(count: int) -> str:
    """Say what to do about so many clipped pixels, before why what they are of is rejected."""
    return f'{count} pixels are clipped: lower the exposure; as it is, ' if count else ''


@kernel
def newly_clipped(
    lit: Pixels, unlit: Pixels, saturation: int, table: Array
) -> NDArray[np.int64]:
    """Return the rows of what is rejected and has a peak that is clipped, and was not before."""
    found = np.empty(table.shape[0], np.int64)
    count = 0
    for k in range(table.shape[0]):
        if table[k, FIELDS] == NOTHING or table[k, WAS_CLIPPED] != 0.0:
            continue
        column, row = int(table[k, COLUMN]), int(table[k, ROW])
        if lit[row, column] >= saturation and unlit[row, column] < saturation:
            found[count] = k
            count += 1
    return found[:count]

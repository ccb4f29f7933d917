"""The threshold above which the histogram of the background ends (thesis, section 5.3)."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box, box_about, component_box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
import numpy as np
from numpy.typing import NDArray

EMPTY_BINS = 5  # bins in a row, as the thesis has it
# A bin of so small a part of the pixels, or of one pixel, is nearly empty: below it lies the tail
# of a Gaussian background beyond 3.5 sigma, and the few pixels of the blob that share a level.
NEARLY_EMPTY = 1e-4


def histogram_threshold(pixels: NDArray[np.floating], step: float = 1.0) -> float | None:
    """
    Return the first level above the mode that is followed by 5 (nearly) empty bins.

    The most common level is taken to be the background's (thesis, section 5.3).

    Parameters
    ----------
    pixels : array
        DN.
    step : float
        Width of a bin, DN. The thesis has 1; a sensor of more bits, whose noise is many DN wide,
        would show gaps within the noise.

    Returns
    -------
    float or None
        The upper end of the last bin before the gap, DN; None if the histogram has no gap.

    """
    floor = float(pixels.min())
    # The half keeps whole numbers in the middle of their bins.
    count = np.bincount(np.floor((pixels - floor) / step + 0.5).astype(np.intp).ravel())
    mode = int(np.argmax(count))
    empty = count[mode + 1:] <= max(1.0, NEARLY_EMPTY * pixels.size)
    if empty.size < EMPTY_BINS:
        return None
    gaps = np.lib.stride_tricks.sliding_window_view(empty, EMPTY_BINS).all(axis=1)
    if not gaps.any():
        return None
    return floor + step * (mode + int(np.argmax(gaps)) + 0.5)


def histogram(contrast: Contrast, candidate: Candidate, largest: int) -> Box | None:
    """
    Return the bounding box of what hangs together with a peak above the histogram's threshold.

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
        In the frame, px. None if the histogram has no gap below the peak.

    """
    column, row = candidate.peak
    region = box_about(column, row, largest, largest, contrast.shape)
    signal = contrast.signal(region)
    threshold = histogram_threshold(signal, step=max(1.0, float(np.round(candidate.noise))))
    if threshold is None or signal[row - region.y0, column - region.x0] <= threshold:
        return None
    return component_box(signal > threshold, column, row, region)

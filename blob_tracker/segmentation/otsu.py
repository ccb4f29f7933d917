"""Otsu's threshold, in a window that grows until the threshold repeats (thesis, section 5.3)."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box, box_about, component_box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
import numpy as np
from numpy.typing import NDArray

FIRST_HALF_PX = 4  # px: holds a blob of sigma 0.6 to 2 with background about it
GROWTH = 1.5  # a larger step would jump over the size at which the threshold settles


def otsu_threshold(pixels: NDArray[np.integer]) -> int:
    """
    Return the level k that best parts the pixels in two classes, <= k and > k.

    It maximises the variance between the classes

        omega_0 omega_1 (mu_1 - mu_0)^2 = (mu_T omega(k) - mu(k))^2 / (omega(k) (1 - omega(k)))

    of Otsu, IEEE Trans. SMC-9 (1979), eqs. 14 and 18 (thesis, eqs. 5.2 to 5.5). The thesis'
    eq. 5.10 names the variance of the background class instead, whose maximum is always at the
    top level; the original criterion is what it describes and what is done here.

    Parameters
    ----------
    pixels : array of integers, zero or more
        DN.

    Returns
    -------
    int
        Threshold, DN.

    Raises
    ------
    ValueError
        If all the pixels are equal: there are no two classes.

    """
    floor = int(pixels.min())
    count = np.bincount((pixels - floor).ravel())
    if count.size < 2:
        raise ValueError('all pixels are equal: there is nothing to part')
    probability = count / pixels.size
    omega = np.cumsum(probability)[:-1]
    mu = np.cumsum(probability * np.arange(count.size))
    between = (mu[-1] * omega - mu[:-1]) ** 2 / (omega * (1.0 - omega))
    return floor + int(np.argmax(between))


def otsu_window(contrast: Contrast, candidate: Candidate, largest: int) -> Box | None:
    """
    Return the bounding box of the blob about a peak.

    A window about the peak grows until its Otsu threshold is that of the window before; the
    blob is what hangs together with the peak above that threshold.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    candidate : Candidate
        What lit up.
    largest : int
        Half the width at which the window stops growing, px.

    Returns
    -------
    Box or None
        The blob's bounding box in the frame, px. None if no background was found about it.

    """
    column, row = candidate.peak
    half = FIRST_HALF_PX
    last = -1
    while True:
        box = box_about(column, row, half, half, contrast.shape)
        # What became darker is background.
        window = np.maximum(contrast.signal(box), 0.0).astype(np.int32)
        full = half >= largest
        if window.min() == window.max():  # all of it brightened alike: there is no outside yet
            if full:
                return None
            threshold = -1
        else:
            threshold = otsu_threshold(window)
            if threshold == last or full:
                return component_box(window > threshold, column, row, box)
        last = threshold
        half = min(int(np.ceil(GROWTH * half)), largest)

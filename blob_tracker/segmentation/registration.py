"""Lay the unlit frame over the lit one, for a camera that moves between the two."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

FARTHEST = 0.25  # of the frame's smaller side: what is found beyond it is a false match
LEAST_RESPONSE = 0.05  # of the phase correlation, whose peak is 1 for equal pictures
CORNERS = 200  # points that are followed
LEAST_CORNERS = 12  # of them must agree, four times what an affine map needs
CORNER_SPACING = 12  # px
FLOW_WINDOW = 31  # px, with three levels of the pyramid it follows 8 px and far more
AGREEMENT = 0.5  # px from the common map; a corner on something that moves by itself is further


def translation(lit: Pixels, unlit: Pixels) -> NDArray[np.float64] | None:
    """
    Return the (2, 3) map from places in the unlit frame to places in the lit one: a shift.

    It is the peak of the phase correlation of the two frames (Kuglin and Hines, 1975), under a
    Hanning window.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.

    Returns
    -------
    (2, 3) array or None
        px; None where the frames do not correlate.

    """
    window = _hanning(lit.shape[1], lit.shape[0])
    # A level that stays would, under the window, be a pattern that does not move.
    before, after = (
        image.astype(np.float32) - np.float32(cv2.mean(image)[0]) for image in (unlit, lit)
    )
    (x, y), response = cv2.phaseCorrelate(before, after, window)
    if not response >= LEAST_RESPONSE or max(abs(x), abs(y)) > FARTHEST * min(lit.shape):
        return None
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y]])


def affine(lit: Pixels, unlit: Pixels) -> NDArray[np.float64] | None:
    """
    Return the (2, 3) map from places in the unlit frame to places in the lit one: affine.

    Corners (Shi and Tomasi, 1994) are followed by pyramidal optical flow (Lucas and Kanade), and
    the map is that on which most of them agree (RANSAC): the target and whatever moves by itself
    are left out.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.

    Returns
    -------
    (2, 3) array or None
        px; None where too few corners agree.

    """
    before, after = _eight_bit(unlit, lit)
    corners = cv2.goodFeaturesToTrack(before, CORNERS, 0.01, CORNER_SPACING)
    if corners is None or len(corners) < LEAST_CORNERS:
        return None
    moved, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        corners,
        np.empty_like(corners),
        winSize=(FLOW_WINDOW, FLOW_WINDOW),
        maxLevel=3,
    )
    kept = status.ravel() == 1
    if kept.sum() < LEAST_CORNERS:
        return None
    found, agree = cv2.estimateAffine2D(
        corners[kept], moved[kept], ransacReprojThreshold=AGREEMENT
    )
    if found is None or agree.sum() < LEAST_CORNERS:
        return None
    return np.asarray(found)


REGISTRATIONS: dict[str, Callable[[Pixels, Pixels], NDArray[np.float64] | None] | None] = {
    'none': None,
    'translation': translation,
    'affine': affine,
}


def laid_over(lit: Pixels, unlit: Pixels, found: NDArray[np.float64]) -> Pixels:
    """
    Return the unlit frame as the camera would have seen it from where the lit one was taken.

    Between pixels it is interpolated (Catmull-Rom), which keeps texture and smooths noise. Where
    the unlit frame did not reach it is the lit one: nothing rises there.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    found : (2, 3) array
        From places in the unlit frame to places in the lit one, px.

    Returns
    -------
    (h, w) array
        DN, of the type of the frames.

    """
    out = lit.copy()
    cv2.warpAffine(
        unlit,
        found,
        (lit.shape[1], lit.shape[0]),
        dst=out,
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_TRANSPARENT,
    )
    return out


def _hanning(width: int, height: int) -> NDArray[np.float32]:
    """Return the (h, w) window that lets the borders fade out."""
    return np.asarray(cv2.createHanningWindow((width, height), cv2.CV_32F))


def _eight_bit(first: Pixels, second: Pixels) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return both frames in 8 bits, scaled alike: what corners and flow work on."""
    if first.dtype == np.uint8:
        return first.astype(np.uint8), second.astype(np.uint8)
    scale = 255.0 / max(int(first.max()), int(second.max()), 1)
    return (
        np.asarray(cv2.convertScaleAbs(first, alpha=scale)),
        np.asarray(cv2.convertScaleAbs(second, alpha=scale)),
    )

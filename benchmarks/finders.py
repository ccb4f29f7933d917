"""Other people's ways to find a spot in a whole frame: each gives the best answer that it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from blob_tracker.types import Pixels
import cv2
import numpy as np

Place = tuple[float, float]

# Standard deviation of the difference of two frames of the clutter scenes where there is nothing
# but the wall: sqrt(2 (40 / 40 + 0.7^2 + 1/12)) DN. All of them are told it.
NOISE = 1.77
CUT = 3.0  # in NOISE: the lowest threshold; of 3, 3.5, 4 and 5 with it all of them find most
LEVELS = 12  # thresholds of the detector from there to the brightest pixel
LEAST_AREA, GREATEST_AREA = 2.0, 1500.0  # px: of 2 and 4 the better; blobs of sigma 4 entire


@dataclass(frozen=True)
class Finder:
    """
    One way with the setting that it is run at.

    Parameters
    ----------
    name, setting : str
        As they stand in the tables.
    find : callable
        From the (h, w) lit frame and the unlit one before it, which it is told apart, to the
        place in px, or None.

    """

    name: str
    setting: str
    find: Callable[[Pixels, Pixels], Place | None]


def brightest_pixel(lit: Pixels, unlit: Pixels) -> Place | None:
    """Return the brightest pixel of the positive difference."""
    _, _, _, (x, y) = cv2.minMaxLoc(cv2.subtract(lit, unlit))
    return float(x), float(y)


def largest_contour(lit: Pixels, unlit: Pixels) -> Place | None:
    """Return the middle of the largest contour of the thresholded absolute difference."""
    _, above = cv2.threshold(cv2.absdiff(lit, unlit), CUT * NOISE, 255, cv2.THRESH_BINARY)
    contours, _ = cv2.findContours(above, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    # The area between a contour's points is 0 for one pixel and for a row of them.
    largest = max(contours, key=lambda contour: (cv2.contourArea(contour), len(contour)))
    (x, y), _ = cv2.minEnclosingCircle(largest)
    return float(x), float(y)


def blob_in_difference(lit: Pixels, unlit: Pixels) -> Place | None:
    """Return the brightest blob that SimpleBlobDetector finds in the positive difference."""
    return _brightest_blob(np.asarray(cv2.subtract(lit, unlit), lit.dtype), CUT * NOISE)


def blob_in_lit_frame(lit: Pixels, unlit: Pixels) -> Place | None:
    """Return the brightest blob that SimpleBlobDetector finds in the lit frame alone."""
    noise = NOISE / np.sqrt(2.0)  # of one frame
    return _brightest_blob(lit, float(np.median(lit[::4, ::4])) + CUT * float(noise))


def _brightest_blob(image: Pixels, lowest: float) -> Place | None:
    """Return the centre of the blob of the highest brightness; None if there is none."""
    brightest = float(image.max())
    if brightest <= lowest:
        return None
    settings = cv2.SimpleBlobDetector.Params()
    settings.filterByColor, settings.blobColor = True, 255
    settings.filterByArea = True
    settings.minArea, settings.maxArea = LEAST_AREA, GREATEST_AREA
    settings.filterByCircularity = settings.filterByConvexity = False
    settings.filterByInertia, settings.minInertiaRatio = True, 0.1
    settings.minThreshold, settings.maxThreshold = lowest, brightest + 1.0
    settings.thresholdStep = max((brightest - lowest) / LEVELS, 1.0)
    settings.minRepeatability = 2
    settings.minDistBetweenBlobs = 5.0
    found = cv2.SimpleBlobDetector.create(settings).detect(image)
    if not found:
        return None
    smooth = np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0))
    x, y = max((key.pt for key in found), key=lambda at: smooth[round(at[1]), round(at[0])])
    return float(x), float(y)


FINDERS = (
    Finder(
        'OpenCV SimpleBlobDetector, difference',
        f'lit - unlit above {CUT:g} noise sigma, {LEVELS} thresholds to the brightest pixel, '
        f'{LEAST_AREA:g} to {GREATEST_AREA:g} px, the brightest of the blobs',
        blob_in_difference,
    ),
    Finder(
        'OpenCV SimpleBlobDetector, lit frame',
        f'the same on the lit frame above its median + {CUT:g} noise sigma',
        blob_in_lit_frame,
    ),
    Finder('brightest pixel of the difference', 'lit - unlit', brightest_pixel),
    Finder(
        'absdiff + contours',
        f'|lit - unlit| above {CUT:g} noise sigma, the largest contour',
        largest_contour,
    ),
)

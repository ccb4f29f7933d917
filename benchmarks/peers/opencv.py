"""OpenCV: image moments and SimpleBlobDetector."""

from __future__ import annotations

from benchmarks.contender import Contender
from benchmarks.windows import Positions, signal, signal_variance, Windows
import cv2
import numpy as np
from numpy.typing import NDArray

PAD = 4  # px of background around a window: the detector drops blobs that touch the edge
LEVELS = 20  # thresholds of the detector between background and peak
_BLOB = cv2.SimpleBlobDetector.Params()
_BLOB.filterByColor, _BLOB.blobColor = True, 255
_BLOB.filterByArea, _BLOB.minArea, _BLOB.maxArea = True, 1.0, 1e6
_BLOB.filterByCircularity = _BLOB.filterByConvexity = _BLOB.filterByInertia = False
_BLOB.minThreshold, _BLOB.maxThreshold, _BLOB.thresholdStep = 20.0, 250.0, 230.0 / LEVELS
_BLOB.minDistBetweenBlobs = 2.0


def _moments(windows: Windows) -> Positions:
    noise = np.sqrt(signal_variance(windows).min(axis=(1, 2)))
    found = np.full((len(noise), 2), np.nan)
    for index, data in enumerate(signal(windows)):
        _, above = cv2.threshold(data, 3.0 * noise[index], 0.0, cv2.THRESH_TOZERO)
        moments = cv2.moments(above)
        if moments['m00'] > 0.0:
            found[index] = moments['m10'] / moments['m00'], moments['m01'] / moments['m00']
    return found[:, 0], found[:, 1]


def _eight_bit(window: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Stretch background to peak over 8 bits and pad it with the background."""
    scaled = np.clip(window * (255.0 / max(window.max(), 1.0)), 0, 255).astype(np.uint8)
    return np.pad(scaled, PAD)


def _blobs(windows: Windows) -> Positions:
    detector = cv2.SimpleBlobDetector.create(_BLOB)
    centre = (np.array(windows.lit.shape[:0:-1]) - 1) / 2
    found = np.full((len(windows.lit), 2), np.nan)
    for index, data in enumerate(signal(windows)):
        points = [np.array(key.pt) - PAD for key in detector.detect(_eight_bit(data))]
        if points:
            found[index] = min(points, key=lambda point: np.hypot(*(point - centre)))
    return found[:, 0], found[:, 1]


PEERS = (
    Contender(
        'OpenCV moments',
        'background subtracted, below 3 noise sigma set to zero',
        _moments,
        share=0.2,
    ),
    Contender(
        'OpenCV SimpleBlobDetector',
        f'background subtracted, stretched to 8 bit, {LEVELS} thresholds, nearest to the middle',
        _blobs,
        share=0.05,
    ),
)

"""No flash: the light is on in every frame, and thresholds alone must find it."""

from __future__ import annotations

from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.difference import NOISE_STEP
from blob_tracker.segmentation.flash import Flashed
from blob_tracker.segmentation.history import FrameHistory
from blob_tracker.types import Frame
import cv2
import numpy as np

NORMAL_MAD = 1.4826  # standard deviations of a Gaussian in its median absolute deviation
LEAST_NOISE = float(np.sqrt(1 / 12))  # DN, of the rounding


class Steady:
    """
    Take the brightest pixel of each frame.

    It must stand above the frame's median by `min_snr` standard deviations of the scene, texture
    included: with nothing to subtract, all that the scene shows is noise.

    Parameters
    ----------
    min_snr : float
        Least height, in standard deviations of the scene.
    max_pair_interval : float
        How far the stamps may jump back before the frame counts as a fresh start, s.

    """

    def __init__(self, *, min_snr: float, max_pair_interval: float) -> None:
        self.min_snr = min_snr
        self.reason = 'no frame yet'
        self._history = FrameHistory(1, max_pair_interval)

    def update(self, frame: Frame) -> list[Flashed]:
        """
        Look for the light in the next frame.

        Raises
        ------
        FrameError
            Where the frame cannot follow the one before it.

        """
        self._history.push(frame)
        image = frame.image
        coarse = image[::NOISE_STEP, ::NOISE_STEP].astype(np.float32)
        background = float(np.median(coarse))
        noise = max(NORMAL_MAD * float(np.median(np.abs(coarse - background))), LEAST_NOISE)
        _, top, _, (column, row) = cv2.minMaxLoc(image)
        height = top - background
        if height < self.min_snr * noise:
            self.reason = (
                f'nothing stands out: the brightest pixel is {height:.0f} DN above the median, '
                f'{height / noise:.1f} times the scatter of the scene (min_snr {self.min_snr:g})'
            )
            return []
        contrast = Contrast(image, None, background, noise)
        return [Flashed(column, row, height, contrast, (image,), (), frame)]

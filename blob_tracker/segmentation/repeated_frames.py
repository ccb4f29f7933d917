"""Frames that come twice, under a stamp of their own."""

from __future__ import annotations

import math

from blob_tracker.kernel import kernel
from blob_tracker.types import Frame, Pixels
import numpy as np

# Rows that are looked at first, and pixels in the middle of each: these lie beside each other in
# memory, and the first of them most often tell.
ROWS, ROW_PX = 4, 256
# Of the samples, that change from a frame to the next where a sensor's noise is seen.
LEAST_CHANGE = 1 / 16


class RepeatedFrames:
    """
    Tell which frames show the pixels of the frame before.

    A camera that is slower than it says, a converter of frame rates or a driver that lost a frame
    gives the last one again. No sensor sees the same noise twice; but if there is none, in
    pixels that are all black or drawn by a program, two frames may well be equal. So a frame is a
    repeated one only if those before it did change from one to the next, in 6 % of the pixels
    or more: a flash that lights up less than that is no noise.

    Attributes
    ----------
    count : int
        How many there were.
    warning : str
        What the last frame shows of it; empty if it was a new one.
    last : Frame or None
        That frame.

    """

    def __init__(self) -> None:
        self.count = 0
        self.warning = ''
        self.last: Frame | None = None
        self._noisy = False

    def take(self, frame: Frame, noisy: bool) -> None:
        """Take a frame that is not the last one again, and whether noise is seen in it."""
        self.last, self._noisy, self.warning = frame, noisy, ''

    def push(self, frame: Frame) -> bool:
        """
        Take the next frame; tell whether it is the one before once more.

        Its pixels lie one after the other in memory, see `history.plain`.
        """
        last, self.last = self.last, frame
        self.warning = ''
        if last is None:
            return False
        image, before = frame.image, last.image
        if (
            before.shape != image.shape
            or before.dtype != image.dtype
            or last.stamp_ns >= frame.stamp_ns  # a frame that is refused, or another sequence
        ):
            self._noisy = False
            return False
        planes = 1
        if image.ndim == 3:
            planes = image.shape[2]
            image, before = (each.reshape(len(each), -1) for each in (image, before))
        changed, enough = changed_samples(image, before, planes)
        if changed > 0:
            self._noisy = changed >= enough
            return False
        if not (self._noisy and np.array_equal(frame.image, last.image)):
            return False
        if frame.image.min() == frame.image.max():
            return False
        self.count += 1
        self.warning = (
            f'the frame is identical to the one before it, {self.count} so far: a camera slower '
            'than its stamps, or a driver that repeats what it had'
        )
        return True


@kernel
def changed_samples(image: Pixels, before: Pixels, planes: int) -> tuple[int, int]:
    """Return how many samples of a few rows changed, and how many tell that there is noise."""
    height, width = image.shape
    most = ROW_PX * planes
    left = max((width // planes - ROW_PX) // 2, 0) * planes
    right = min(left + most, width)
    enough = int(math.ceil(LEAST_CHANGE * ROWS * (right - left)))
    changed = 0
    for j in range(height // (2 * ROWS), height, max(height // ROWS, 1)):
        for i in range(left, right):
            changed += image[j, i] != before[j, i]
        if changed >= enough:
            break
    return changed, enough

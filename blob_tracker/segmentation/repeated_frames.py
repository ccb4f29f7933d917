"""Frames that come twice, under a stamp of their own."""

from __future__ import annotations

import functools
import math

from blob_tracker.types import Frame
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
    gives the last one again. No sensor sees the same noise twice; but where there is none, in
    pixels that are all black or drawn by a program, two frames may well be equal. So a frame is a
    repeated one only where those before it did change from one to the next, in 6 % of the pixels
    or more: a flash that lights up less than that is no noise.

    Attributes
    ----------
    count : int
        How many there were.
    warning : str
        What the last frame shows of it; empty where it was a new one.

    """

    def __init__(self) -> None:
        self.count = 0
        self.warning = ''
        self._last: Frame | None = None
        self._noisy = False

    def push(self, frame: Frame) -> bool:
        """Take the next frame; tell whether it is the one before once more."""
        last, self._last = self._last, frame
        self.warning = ''
        if (
            last is None
            or last.image.shape != frame.image.shape
            or last.stamp_ns >= frame.stamp_ns  # a frame that is refused, or another sequence
        ):
            self._noisy = False
            return False
        changed = 0
        image, before = frame.image, last.image
        rows, enough = _sampled(image.shape)
        for row in rows:
            # As bytes of 0 and 1, whose count takes half of the time of NumPy's.
            changed += (image[row] != before[row]).tobytes().count(1)
            if changed >= enough:
                break
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


@functools.cache
def _sampled(shape: tuple[int, ...]) -> tuple[list[tuple[int, slice]], int]:
    """Return which parts of rows are looked at first, and how many changes there are noise."""
    height, width = shape[:2]
    left = max((width - ROW_PX) // 2, 0)
    middle = slice(left, left + ROW_PX)
    rows = [
        (row, middle) for row in range(height // (2 * ROWS), height, height // ROWS or 1)
    ]
    samples = min(width, ROW_PX) * math.prod(shape[2:])
    return rows, math.ceil(LEAST_CHANGE * ROWS * samples)

"""What the scene looks like without the lights that blink in it, from the last frames."""

from __future__ import annotations

from collections import deque

from blob_tracker.kernel import kernel
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.tile_noise import median, tile_noise
from blob_tracker.types import Frame, Pixels
import numpy as np

# Of full scale, by which the envelope rises in a frame: in 8 bits 1 DN in every fourth, 15 DN/s
RISE = 1 / 1020
MORE_EVEN = 0.8  # of the noise, texture included: what is taken off brings noise of its own
FEWEST = 4  # frames that make an envelope
KEPT = 12  # frames, among which one is looked for in which the light was dark
# Standard deviations: what the brightest of some hundred pixels is above the level, and their sum
BRIGHTEST_SIGMA, SUM_SIGMA = 6.0, 4.0
LEVEL_SIGMA = 0.1  # of the noise, to which the level is known that the border of a box tells


class DarkLook:
    """
    Keep the lower envelope of each pixel over time, and the frames that it is of.

    It falls with a pixel at once and rises slowly: a light that blinks or moves is not in it, the
    scene of a camera at rest is, less some 2 standard deviations of the noise everywhere. Of a
    camera that moves it is nearly even, and taken off a frame it changes nothing.

    Attributes
    ----------
    envelope : (h, w) array
        DN.

    """

    def __init__(self) -> None:
        self.envelope: Pixels = np.empty((0, 0), np.uint8)
        self._frames: deque[Frame] = deque(maxlen=KEPT)
        self._owed = 0.0
        self._nothing: Pixels = np.empty((0, 0), np.uint8)

    def push(self, frame: Frame) -> None:
        """Take the next frame."""
        image = frame.image
        if self.envelope.shape != image.shape or self.envelope.dtype != image.dtype:
            self.envelope = image.copy()
            self._frames.clear()
        self._owed += RISE * frame.saturation
        step = int(self._owed)
        self._owed -= step
        lower(image, self.envelope, step)
        self._frames.append(frame)

    def below(self, frame: Frame) -> Pixels:
        """
        Return what is taken off the next frame: the envelope where it has more noise without.

        The envelope is that of the frames before it: one that held the frame itself would clip
        its noise.
        """
        image = frame.image
        if self._nothing.shape != image.shape or self._nothing.dtype != image.dtype:
            self._nothing = np.zeros_like(image)
        if len(self._frames) < FEWEST:
            return self._nothing
        height, width = image.shape
        _, alone, _ = tile_noise(image, self._nothing, 0, 0, width, height, 0.0)
        _, less, _ = tile_noise(image, self.envelope, 0, 0, width, height, 0.0)
        tiles = less.size
        helps = median(less.ravel(), tiles) < MORE_EVEN * median(alone.ravel(), tiles)
        return self.envelope if helps else self._nothing

    def of(self, box: Box, noise: float) -> Pixels | None:
        """
        Return the raw pixels of the last frame that was dark in a box; None if none was.

        Parameters
        ----------
        box : Box
            In the frame.
        noise : float
            Standard deviation of a frame less the envelope there, DN.

        """
        level = self._level(box)
        for frame in reversed(self._frames):
            if is_dark(
                frame.image, self.envelope, (box.x0, box.y0, box.x1, box.y1), level, noise
            ):
                return frame.samples
        return None

    def _level(self, box: Box) -> float:
        """
        Return the mean of a frame less the envelope along the border of a box, DN.

        The lower quartile of the frames: most of them may have a light there that is seldom off.
        """
        inside = np.s_[box.y0:box.y1, box.x0:box.x1]
        below = self.envelope[inside].astype(np.float32)
        border = np.ones(below.shape, np.bool_)
        border[1:-1, 1:-1] = False
        rises = [(frame.image[inside] - below)[border].mean() for frame in self._frames]
        return float(np.quantile(rises, 0.25))


@kernel
def lower(image: Pixels, envelope: Pixels, step: int) -> None:
    """Raise the envelope by a step, and bring it down to the image where that is darker."""
    # In the type of the pixels: the fewer their bits the more of them are done at once.
    most = envelope.dtype.type(np.iinfo(envelope.dtype).max - step)
    rise = envelope.dtype.type(step)
    for j in range(image.shape[0]):
        for i in range(image.shape[1]):
            raised = envelope.dtype.type(min(envelope[j, i], most) + rise)
            envelope[j, i] = min(raised, image[j, i])


@kernel
def is_dark(
    image: Pixels, envelope: Pixels, box: tuple[int, int, int, int], level: float, noise: float
) -> bool:
    """Tell whether nothing in a box is brighter than the envelope, but for level and noise."""
    total, count = 0.0, 0
    for j in range(box[1], box[3]):
        for i in range(box[0], box[2]):
            rise = float(image[j, i]) - float(envelope[j, i]) - level
            if abs(rise) > BRIGHTEST_SIGMA * noise:
                return False
            total += rise
            count += 1
    # The level is known to a part of the noise.
    return abs(total) < SUM_SIGMA * noise * np.sqrt(count) + LEVEL_SIGMA * noise * count

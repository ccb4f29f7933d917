"""Samples of fewer than 16 bits in words of 16, moved to the top: where they are clipped."""

from __future__ import annotations

from blob_tracker.types import Pixels
import numpy as np

FULL = 65535
FRAMES = 32  # that are looked at
MOST = 8  # bits that may be missing: more are those of a picture without light


class LowBits:
    """
    The lowest bits of the samples, which are 0 in all of them where the sensor has fewer.

    A camera of 12 bits gives them as Y16 or 16-bit Bayer in steps of 16, its clipped pixels are
    65520. Noise sets the lowest bit of every other sample, so that one frame tells which it is.

    Parameters
    ----------
    binning : int
        Samples along an axis that are averaged in a pixel: 2 leaves one bit fewer at 0.

    """

    def __init__(self, binning: int = 1) -> None:
        self._halved = binning - 1
        self._seen = 0
        self._left = FRAMES

    def saturation(self, image: Pixels) -> int:
        """
        Return the DN at which pixels are clipped, by this picture and those before.

        Parameters
        ----------
        image : (h, w) or (h, w, n) uint16 array
            The next one.

        """
        if self._left and not self._seen & 1:
            self._left -= 1
            self._seen |= int(np.bitwise_or.reduce(image, axis=None))
        # The lowest bit that any sample has.
        missing = (self._seen & -self._seen).bit_length() - 1 + self._halved
        if self._seen & 1 or not self._seen or missing > MOST:
            return FULL
        return FULL >> missing << missing

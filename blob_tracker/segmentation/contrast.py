"""A frame against what it looks like without the target."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.segmentation.box import Box
from blob_tracker.types import Frame, Pixels
import numpy as np
from numpy.typing import NDArray

ROUNDING_DN = float(np.sqrt(2 / 12))  # DN: noise of the difference of two rounded frames


class Contrast(NamedTuple):
    """
    Where the target is looked for; subtracted only where it is looked at.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        With and without the target, C-contiguous and of one type, uint8 or uint16.
    saturation : int
        Value at which a pixel of them is clipped.
    frame : Frame
        Gives stamp, crop, binning, and the raw frames' saturation; its `mosaic` says that these
        are twice as wide and high, and which of their pixels count.
    lit_frames, unlit_frames : tuple of (h, w) arrays
        The raw frames from which the window is cut; as many of each, or no unlit ones.
    floor : float
        Least noise of lit less unlit.
    unit : float
        DN in one step of `lit` and `unlit`.
    duration : float
        From one flash of the light to the next, s, where that may be long.

    """

    lit: Pixels
    unlit: Pixels
    saturation: int
    frame: Frame
    lit_frames: tuple[Pixels, ...]
    unlit_frames: tuple[Pixels, ...]
    floor: float = ROUNDING_DN
    unit: float = 1.0
    duration: float = 0.0

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self.lit.shape[0], self.lit.shape[1]

    def signal(self, box: Box) -> NDArray[np.float32]:
        """Return (h, w) DN of lit less unlit within a box, with its sign."""
        import cv2  # no part of a start

        return np.asarray(
            cv2.subtract(self.lit[box.slices], self.unlit[box.slices], dtype=cv2.CV_32F)
        )

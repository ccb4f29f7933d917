"""What stands out in a frame: the lit pixels, and the unlit ones that are taken off."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.segmentation.box import Box
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray


class Contrast(NamedTuple):
    """
    A frame against what it looks like without the target; subtracted only where it is looked at.

    Parameters
    ----------
    lit : (h, w) array
        DN with the light on.
    unlit : (h, w) array or None
        DN with the light off; None where there is no such frame.
    background : float
        Level of lit less unlit where there is no target, DN.
    noise : float
        Standard deviation of lit less unlit, DN.

    """

    lit: Pixels
    unlit: Pixels | None
    background: float
    noise: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self.lit.shape[0], self.lit.shape[1]

    def signal(self, box: Box) -> NDArray[np.float32]:
        """Return (h, w) DN of lit less unlit within a box, with its sign."""
        lit = self.lit[box.slices]
        if self.unlit is None:
            return lit.astype(np.float32)
        return np.asarray(cv2.subtract(lit, self.unlit[box.slices], dtype=cv2.CV_32F))

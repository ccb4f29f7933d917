"""What every flash mode gives: a peak that may be the target, and the frames it stands out of."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.types import Frame, Pixels


class Flashed(NamedTuple):
    """
    A peak in the light that changed, as the target would change it.

    Parameters
    ----------
    column, row : int
        Pixel of the peak.
    height : float
        Its height above the background, DN.
    contrast : Contrast
        Target against background: what the window is measured on.
    lit, unlit : tuple of (h, w) arrays
        The raw frames with and without the target; as many of each, or no unlit ones.
    frame : Frame
        Gives stamp, crop, binning and saturation.
    name : str
        Which light it is; empty where there is only one.
    search : (h, w) array or None
        Where further peaks are looked for if this one is not the target; it is written to. None
        where there is no other.
    least : float
        Height that a peak must have, DN.
    min_snr : float
        Least SNR of its matched filter; 0 where the mode has judged it.

    """

    column: int
    row: int
    height: float
    contrast: Contrast
    lit: tuple[Pixels, ...]
    unlit: tuple[Pixels, ...]
    frame: Frame
    name: str = ''
    search: Pixels | None = None
    least: float = 0.0
    min_snr: float = 0.0


class Flash(Protocol):
    """
    A flash mode.

    Attributes
    ----------
    reason : str
        Why the last frame gave nothing.

    """

    reason: str

    def update(self, frame: Frame) -> list[Flashed]:
        """
        Take the next frame and return the lights that it shows, none or more.

        Raises
        ------
        FrameError
            Where the frame cannot follow those before it.

        """

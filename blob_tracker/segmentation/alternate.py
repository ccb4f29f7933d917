"""Camera and light in step: the light is on in every other frame."""

from __future__ import annotations

from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.difference import strongest_rise
from blob_tracker.segmentation.flash import Flashed
from blob_tracker.segmentation.history import FrameHistory
from blob_tracker.segmentation.registration import laid_over, REGISTRATIONS
from blob_tracker.types import Frame, Pixels
import numpy as np


# A peak pixel this part of the SNR asked for is looked at; its blob must have all of it. A blob of
# sigma 0.6 px has 1.1 times its peak pixel's SNR in a matched filter, wider ones far more.
PEAK_PART = 0.7


class Alternate:
    """
    Compare each frame with the one before it.

    Where a pixel rose by more than the noise can, the frame is the lit one and its neighbour the
    unlit one; where light went out, or nothing changed, there is no target in that frame. So the
    phase of the flash need not be known, and a dropped or repeated frame costs its own pair and
    no more.

    Parameters
    ----------
    min_snr : float
        Least SNR of the matched filter; 0.7 of it in the brightest pixel.
    max_pair_interval : float
        Greatest time between the two frames of a pair, s.
    registration : str
        How the unlit frame is laid over the lit one, a key of `REGISTRATIONS`: for a camera that
        moves between the two. It is none for one that stands still.

    Raises
    ------
    ValueError
        Where there is no such registration.

    """

    def __init__(
        self, *, min_snr: float, max_pair_interval: float, registration: str = 'none'
    ) -> None:
        if registration not in REGISTRATIONS:
            raise ValueError(
                f"no registration '{registration}'; there is {', '.join(REGISTRATIONS)}"
            )
        self._register = REGISTRATIONS[registration]
        self.min_snr = min_snr
        self.reason = 'no frame yet'
        self._history = FrameHistory(2, max_pair_interval)
        self._rise: Pixels | None = None

    def update(self, frame: Frame) -> list[Flashed]:
        """
        Compare the next frame with the one before it.

        Raises
        ------
        FrameError
            Where the frame cannot follow the one before it.

        """
        interval = self._history.push(frame)
        if interval is None:
            self.reason = 'waiting for a second frame'
            return []
        if interval > self._history.max_interval:
            self.reason = (
                f'frames {interval:.3f} s apart; a pair may be at most '
                f'{self._history.max_interval:.3f} s apart (max_pair_interval)'
            )
            return []
        unlit = self._history.frames[0].image
        if self._register is not None:
            found = self._register(frame.image, unlit)
            if found is None:
                self.reason = 'the unlit frame has too little in common with the lit one'
                return []
            unlit = laid_over(frame.image, unlit, found)
        if self._rise is None or self._rise.shape != unlit.shape:
            self._rise = np.empty_like(frame.image)
        peak = strongest_rise(frame.image, unlit, self._rise)
        least = PEAK_PART * self.min_snr * peak.noise
        if peak.height < least:
            self.reason = (
                f'nothing lit up: the strongest rise is {peak.height:.0f} DN, '
                f'{peak.height / peak.noise:.1f} times the noise (min_snr {self.min_snr:g})'
            )
            return []
        contrast = Contrast(frame.image, unlit, peak.background, peak.noise)
        return [Flashed(
            peak.column,
            peak.row,
            peak.height,
            contrast,
            (frame.image,),
            (unlit,),
            frame,
            search=self._rise,
            least=least,
            min_snr=self.min_snr,
        )]

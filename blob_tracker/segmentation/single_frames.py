"""Each frame by itself: what stands out of it are points, whatever they do in others."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.kernel import Array
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.dark_look import DarkLook
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.history import FrameError, FrameHistory
from blob_tracker.segmentation.points import LEAST_PEAK_SIGMA, points
from blob_tracker.segmentation.whole_frame import WholeFrame
from blob_tracker.types import Frame
import numpy as np

ROUNDING_DN = float(np.sqrt(1 / 12))  # DN, of one frame


class SingleFrames(WholeFrame):
    """
    Compare each frame with what the scene looks like without lights that blink.

    Parameters
    ----------
    max_pair_interval : float
        Greatest time from one frame to the next, s; a longer gap forgets all frames; 0 as
        `FrameHistory` has it.

    """

    finding = ''

    def __init__(self, max_pair_interval: float) -> None:
        self._history = FrameHistory(2, max_pair_interval)
        self._dark = DarkLook()
        self.reason = 'no frame yet'
        self.warning = ''

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Return the next frame, and what the scene looks like without lights that blink.

        Raises
        ------
        FrameError
            If the frame cannot follow the one before it.

        """
        try:
            interval = self._history.push(frame)
        except FrameError:
            if len(self._history.frames) == 1:
                self._begin()
            raise
        kept = self._history.frames[-1]
        if interval is None or len(self._history.frames) < 2:
            self._begin()
        else:
            self._dark.push(self._history.frames[-2])
            self.reason = self._follow(kept, interval)
            if self.reason:
                return None
        return Contrast(
            kept.image, self._dark.below(kept), frame.saturation, frame, (kept.samples,), (),
            ROUNDING_DN,
        )

    def _begin(self) -> None:
        """Forget all frames but the last one, which begins a new series."""
        self._dark = DarkLook()

    def _follow(self, frame: Frame, interval: float) -> str:
        """Take note of the time since the frame before, s; return what speaks against it."""
        return ''


def seen_points(
    contrast: Contrast, candidates: Sequence[Candidate]
) -> tuple[list[Candidate], Array, float]:
    """Return the candidates that may be lights, their points, and the flux of the faintest."""
    # What is no higher may be the scene's texture: a wide filter sums it up as it does light.
    allowed = [
        each for each in candidates
        if not each.rejected and each.amplitude >= LEAST_PEAK_SIGMA * each.noise
    ]
    table, least = points(contrast, allowed, max(
        (each.noise for each in candidates), default=contrast.floor
    ))
    return allowed, table, least

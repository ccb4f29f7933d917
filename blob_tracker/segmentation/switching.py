"""What flash modes have in common that go on in the way of one mode or of another."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.flash import Flash
from blob_tracker.types import Frame


class Switching:
    """
    Hand on what the mode of the time does.

    Parameters
    ----------
    mode : Flash
        The first.

    """

    def __init__(self, mode: Flash) -> None:
        self._mode = mode

    @property
    def locked(self) -> bool:
        """Whether the target is followed."""
        return self._mode.locked

    @property
    def warning(self) -> str:
        """Say what is wrong though the target may be there; empty if nothing is."""
        return self._mode.warning

    @property
    def surveys(self) -> bool:
        """Whether `survey` asks for all that lit up in the whole frame, after `choose`."""
        return self._mode.surveys

    def skip(self, frame: Frame) -> None:
        """Take note of a frame that is left out: it shows the one before it once more."""
        self._mode.skip(frame)

    def region(self, contrast: Contrast) -> Box:
        """Return the part of the frame in which the target can be."""
        return self._mode.region(contrast)

    def widened(self, contrast: Contrast, candidates: Sequence[Candidate]) -> Contrast | None:
        """Return the contrast of a wider region, where the mode of the time has need of one."""
        return self._mode.widened(contrast, candidates)

    def survey(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Take note of all that lit up in the whole frame."""
        self._mode.survey(contrast, candidates)

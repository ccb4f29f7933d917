"""What flash modes have in common that look for their lights in the whole of each frame."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.box import Box, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.types import Frame


class WholeFrame:
    """The methods of `Flash` that such a mode has no use for."""

    surveys = False

    def skip(self, frame: Frame) -> None:
        """Do nothing: it is as if the frame had not come."""

    def region(self, contrast: Contrast) -> Box:
        """Return the whole frame: the lights may be anywhere in it."""
        return whole(contrast.shape)

    def widened(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Return None: the whole frame is searched in any case."""

    def survey(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Do nothing: `choose` had the whole frame."""

"""What a flash mode does: say what to compare, where to look, and which light is the target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.types import Frame


class Flash(Protocol):
    """
    A flash mode; for each frame its methods are called in the order in which they stand here.

    Attributes
    ----------
    reason : str
        Why the last frame gave no light.
    locked : bool
        Whether the target is followed.
    warning : str
        What is wrong though the target may be there; empty if nothing is.
    finding : str
        What it found out about the light that it was not told; empty if it was told all.
    surveys : bool
        Whether `survey` asks for all that lit up in the whole frame, after `choose`.

    Examples
    --------
    Each mode of `FLASH_MODES` is one:

    >>> from blob_tracker.segmentation import flash_by_name
    >>> flash = flash_by_name('alternate')
    >>> flash.locked
    False
    >>> flash.reason
    'no frame yet'

    """

    @property
    def reason(self) -> str:
        """Why the last frame gave no light."""

    @property
    def locked(self) -> bool:
        """Whether the target is followed."""

    @property
    def warning(self) -> str:
        """Say what is wrong though the target may be there; empty if nothing is."""

    @property
    def finding(self) -> str:
        """Say what it found out about the light; empty if it was told all."""

    @property
    def surveys(self) -> bool:
        """Whether `survey` asks for all that lit up in the whole frame, after `choose`."""

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Take the next frame; return what to compare, or None if there is nothing yet.

        A mode that looks for its light in the whole frame makes no use of where it is expected.

        Raises
        ------
        FrameError
            If the frame cannot follow those before it.

        """

    def skip(self, frame: Frame) -> None:
        """Take note of a frame that is left out: it shows the one before it once more."""

    def region(self, contrast: Contrast) -> Box:
        """Return the part of the frame in which the target can be."""

    def widened(self, contrast: Contrast, candidates: Sequence[Candidate]) -> Contrast | None:
        """
        Return the contrast of a wider region; None if there is no need of it, or none such.

        It is needed where the target is due in a region and is not among what lit up there: the
        expectation was wrong, or it has turned. `region` is the wider one from then on; it is
        asked for again, until there is none.
        """

    def survey(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Take note of all that lit up in the whole frame."""

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return name and place of the lights that the frame shows, of all that lit up."""

"""Several lights without names at once: all steady, or all in step with the camera."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.frame_clock import PERIOD_FRAMES
from blob_tracker.segmentation.history import FrameHistory
from blob_tracker.segmentation.numbering import Numbering
from blob_tracker.segmentation.steady import above_the_scene, Steady
from blob_tracker.segmentation.whole_frame import WholeFrame
from blob_tracker.types import Frame

LEAST_FLASHES = 3  # in every other frame: chance lights up twice in one place, seldom three times


class SteadyLights(Steady):
    """
    Take the blobs of each frame that stand out most, each above the scene as `Steady` has it.

    Parameters
    ----------
    lights : int
        How many at most.
    max_pair_interval
        That of `Steady`.
    gate_px : float
        Greatest way of a light in the picture from one frame to the next, px.

    """

    def __init__(
        self, *, lights: int, max_pair_interval: float = 0.0, gate_px: float = 24.0
    ) -> None:
        super().__init__(max_pair_interval=max_pair_interval)
        self._numbering = Numbering(lights, gate_px)
        self._frame = 0

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the candidates of the highest SNR that the scene does not explain."""
        self._frame += 1
        found = above_the_scene(candidates)
        if not found:
            self.reason = self._why_none(candidates)
        return self._numbering.take(self._frame, found)


class AlternateLights(WholeFrame):
    """
    Take what lights up in every other frame, wherever it is: lights that the camera switches.

    Each frame is compared with the one before it. A light is believed from its third flash on;
    what lights up one or three frames later is out of step, and begins anew.

    Parameters
    ----------
    lights : int
        How many at most.
    max_pair_interval, gate_px
        Those of `Alternate`.
    registration : str
        Only none.

    Raises
    ------
    ValueError
        If the frames are to be laid over each other.

    """

    locked = False
    warning = ''
    finding = ''

    def __init__(
        self, *, lights: int, max_pair_interval: float = 0.0, gate_px: float = 24.0,
        registration: str = 'none',
    ) -> None:
        if registration != 'none':
            raise ValueError(
                f"registration is '{registration}'; with several lights (flash.lights) it must be "
                "'none'"
            )
        self.reason = 'no frame yet'
        self._history = FrameHistory(2, max_pair_interval)
        self._numbering = Numbering(
            lights, gate_px, period=PERIOD_FRAMES, least_run=LEAST_FLASHES)
        self._frame = 0

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Return the next frame and the one before it.

        Raises
        ------
        FrameError
            If the frame cannot follow the one before it.

        """
        self._frame += 1
        interval = self._history.push(frame)
        if interval is None:
            self.reason = 'waiting for a second frame'
            return None
        if len(self._history.frames) < 2:
            self._frame += 1  # or what was lost in the gap would pass for one frame
            self.reason = (
                f'frames {interval:.3f} s apart; a pair may be at most '
                f'{self._history.max_interval:.3f} s apart (max_pair_interval)'
            )
            return None
        self.reason = ''
        before, after = self._history.frames
        return Contrast(
            after.image, before.image, frame.saturation, frame, (after.samples,),
            (before.samples,),
        )

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return what flashes in step with the frames."""
        allowed = [each for each in candidates if not each.rejected]
        found = self._numbering.take(self._frame, allowed)
        if allowed and not found:
            self.reason = (
                f'{len(allowed)} lit up; none of them flashes in step with the frames yet'
            )
        return found

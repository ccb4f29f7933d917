"""Camera and light in step: the light is on in every other frame."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.at_once import Asked, LIT_UP, Shown, Watched
from blob_tracker.segmentation.box import Box, intersection, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.confirmation import Confirmation
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.description import FIELDS
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.history import FrameError, FrameHistory
from blob_tracker.segmentation.registration import (
    compile_registration, overlap, REGISTRATIONS, warped,
)
from blob_tracker.types import Frame, Pixels
import numpy as np
from numpy.typing import NDArray


class Alternate:
    """
    Compare each frame with the one before it.

    Where something lit up the frame is the lit one and its neighbour the unlit one; where light
    went out, or nothing changed, there is no target in that frame. So the phase of the flash need
    not be known, and a dropped or repeated frame costs its own pair and no more. What lights up
    in every other frame is the target, see `Confirmation`.

    Parameters
    ----------
    max_pair_interval : float
        Greatest time between the two frames of a pair, s; 0 as
        `FrameHistory` has it.
    registration : str
        How the unlit frame is laid over the lit one, a key of `REGISTRATIONS`: for a camera that
        moves between the two. It is none for one that stands still.
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.

    Raises
    ------
    ValueError
        If there is no such registration.

    """

    finding = ''

    def __init__(
        self,
        *,
        max_pair_interval: float = 0.0,
        registration: str = 'none',
        gate_px: float = 24.0,
    ) -> None:
        if registration not in REGISTRATIONS:
            raise ValueError(
                f"no registration '{registration}'; there is {', '.join(REGISTRATIONS)}"
            )
        self._register = REGISTRATIONS[registration]
        if self._register is not None:
            compile_registration()
        self.gate_px = gate_px
        self.reason = 'no frame yet'
        self._history = FrameHistory(2, max_pair_interval)
        self._confirmation = Confirmation(gate_px)
        self._region = Box(0, 0, 0, 0)
        self._motion: NDArray[np.float64] | None = None  # of the camera since the last frame
        self._agreed: Expectation | None = None

    @property
    def locked(self) -> bool:
        """Whether the target is followed."""
        return self._confirmation.locked

    @property
    def interval(self) -> float:
        """Return the time from frame to frame, the median of the last ones, s; 0 before two."""
        return self._confirmation.interval

    @property
    def warning(self) -> str:
        """Name the other lights that flash in step with the target."""
        return self._confirmation.warning

    @property
    def surveys(self) -> bool:
        """Whether the whole frame is to be searched for them."""
        return self._confirmation.surveys and self._motion is None

    def survey(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Take note of other lights that flash in step."""
        self._confirmation.survey(candidates, self._region)

    def agree_with(self, place: Expectation | None) -> None:
        """Say where another view follows the target, for the next frame: see `Confirmation`."""
        self._agreed = place

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Return the next frame and the one before it; where to look is where it is expected.

        Raises
        ------
        FrameError
            If the frame cannot follow the one before it.

        """
        try:
            interval = self._history.push(frame)
        except FrameError:
            if len(self._history.frames) == 1:
                self._confirmation = Confirmation(self.gate_px)
            raise
        if interval is None:
            self.reason = 'waiting for a second frame'
            self._confirmation = Confirmation(self.gate_px)
            return None
        if len(self._history.frames) < 2:
            self.reason = (
                f'frames {interval:.3f} s apart; a pair may be at most '
                f'{self._history.max_interval:.3f} s apart (max_pair_interval)'
            )
            return None
        if expected is not None:
            expected = expected.in_frame(frame)
        agreed = None if self._agreed is None else self._agreed.in_frame(frame)
        self._confirmation.push(frame.stamp_ns, expected, frame.image.shape, agreed)
        self.reason = ''
        if self._register is not None:
            unlit, lit = (each.image for each in self._history.frames)
            self._motion = self._register(lit, unlit)
            if self._motion is None:
                # Little texture leaves little to lay over; what a wrong pair makes is not in step.
                self.reason = (
                    'too little in common with the unlit frame to lay it over the lit one'
                )
        return self._compared(frame)

    def at_once(
        self, frame: Frame, before: Frame, asked: Asked, watched: Watched
    ) -> Shown | None:
        """Take the next frame where nothing is odd about it, see `FlashMemory.at_once`."""
        history = self._history
        if self._register is not None or self._agreed is not None or not (
            history.goes_on(before, frame)
        ):
            return None
        found = self._confirmation.at_once(
            frame.stamp_ns, frame.image, before.image, asked, frame.saturation, watched
        )
        if found is not None:
            history.take(frame, (frame.stamp_ns - before.stamp_ns) / 1e9)
            self.reason = ''
            if found.outcome == LIT_UP:
                self.reason = self._why_none([Candidate(*found.table[0, :FIELDS].tolist())])
        return found

    def _compared(self, frame: Frame) -> Contrast:
        """Return the contrast of the two frames in the region where the target can be."""
        before, after = self._history.frames
        unlit, lit = before.image, after.image
        samples = before.samples
        self._region = self._confirmation.region(lit.shape)
        if self._motion is not None:
            unlit = self._warped(lit, unlit, self._motion)
            samples = self._warped_samples(after, before, unlit, self._motion)
        return Contrast(lit, unlit, frame.saturation, frame, (after.samples,), (samples,))

    def _warped(self, lit: Pixels, unlit: Pixels, motion: NDArray[np.float64]) -> Pixels:
        """Return the unlit frame laid over the lit one in the region, cut to what both see."""
        seen = overlap(motion, (lit.shape[0], lit.shape[1]))
        self._region = intersection(self._region, seen)
        if self._region == whole((lit.shape[0], lit.shape[1])):
            return warped(lit, unlit, motion)
        out = lit.copy()
        out[self._region.slices] = warped(lit, unlit, motion, self._region)
        return out

    def skip(self, frame: Frame) -> None:
        """Let the light be in either phase of the stamps from this frame on."""
        self._confirmation.skip(frame.stamp_ns)

    def _warped_samples(
        self, lit: Frame, unlit: Frame, image: Pixels, motion: NDArray[np.float64]
    ) -> Pixels:
        """Return the unlit samples laid over the lit ones; `image` is the unlit image so laid."""
        if lit.mosaic is None or unlit.mosaic is None:
            return image
        out = lit.samples.copy()
        for row, column in np.argwhere(lit.mosaic.sites):
            plane = slice(row, None, 2), slice(column, None, 2)
            # The motion is that of the image, whose pixels lie between these where it is a sum.
            alone = lit.mosaic.sites.sum() == 1
            place = np.zeros(2) if alone else np.array([column, row]) / 2.0 - 0.25
            own = motion.copy()
            own[:, 2] += motion[:, :2] @ place - place
            out[plane][self._region.slices] = warped(
                lit.samples[plane], unlit.samples[plane], own, self._region
            )
        return out

    def region(self, contrast: Contrast) -> Box:
        """Return the surroundings of the predicted place; the whole frame while it is lost."""
        return self._region

    def widened(self, contrast: Contrast, candidates: Sequence[Candidate]) -> Contrast | None:
        """Return the contrast where else the light may be that is due and not seen."""
        if not self._confirmation.widened(candidates, contrast.shape):
            return None
        return self._compared(contrast.frame)

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the candidate that flashes in step, under the empty name."""
        target = self._confirmation.choose(candidates, contrast.shape)
        if target is not None:
            return [('', target)]
        if self._confirmation.reason:
            self.reason = self._confirmation.reason
        elif not self.reason:
            self.reason = self._why_none(candidates)
        return []

    def _why_none(self, candidates: Sequence[Candidate]) -> str:
        """Say why none of what lit up is the target; empty if nothing did that may be."""
        allowed = [each for each in candidates if not each.rejected]
        if not allowed:
            return ''
        another = self._confirmation.why_another(allowed[0]) if len(allowed) == 1 else ''
        return another or (
            f'{len(allowed)} lit up; none of them flashes in step with the frames yet'
            + (': glints, or lamps?' if len(allowed) > 1 else '')
        )

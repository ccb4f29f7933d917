"""Frames in their order -> the windows of the targets, lit and unlit."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress
from functools import partial
from typing import NamedTuple

from blob_tracker.colour import one_site
from blob_tracker.segmentation.at_once import Asked, Shown
from blob_tracker.segmentation.black_core import without_black_cores
from blob_tracker.segmentation.box import Box, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import Candidates
from blob_tracker.segmentation.channel import ChannelChoice
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.detections import Detections
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash import Flash
from blob_tracker.segmentation.flat_top import FlatTop
from blob_tracker.segmentation.frame_stack import cut_at_once, FrameStack
from blob_tracker.segmentation.history import FrameError, plain
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.segmentation.repeated_frames import RepeatedFrames
from blob_tracker.segmentation.search import NO_MASK, search, SearchResult
from blob_tracker.segmentation.sigma_window import sigma_window
from blob_tracker.segmentation.thresholds import Threshold, threshold_by_name
from blob_tracker.types import Frame, Pixels, Window
import numpy as np
from numpy.typing import NDArray

NOISE = Candidate._fields.index('noise')
ALONE = ('',)  # the names of the lights where there is one
GATED_SNR_FRACTION = 0.85  # of the SNR that is asked for is enough where the target is expected
MAX_UNLIT_INTERVAL_NS = 10**9  # ns between two unlit frames of a pair, at most


class Sighting(NamedTuple):
    """
    A target in a frame.

    Parameters
    ----------
    name : str
        Which light it is; empty if there is only one.
    window : Window
        Its pixels.

    Examples
    --------
    >>> sighting = Sighting('port', Window(lit=np.full((9, 9), 60, np.uint8), x0=312, y0=240))
    >>> sighting.name, sighting.window.x0
    ('port', 312)

    """

    name: str
    window: Window


class Segmenter:
    """
    Find the lights that flash, and cut them out.

    Parameters
    ----------
    flash : Flash, optional
        How the light flashes, see `flash_by_name`; on in every other frame where it is left out.
    threshold : callable, optional
        Finds the window about a peak, see `threshold_by_name`; +-3 sigma where it is left out.
    min_snr : float
        Least SNR of the target in the matched filter.
    max_blob : int
        Greatest half-width of the blob's window, px.
    looks : int
        Windows of a still target that are summed into one, see `FrameStack`.
    mask : (h, w) array, optional
        0 where the target cannot be; of the frames' size.
    channel : ChannelChoice, optional
        Which colour of a colour camera's frames is searched; the one that flashes strongest where
        it is left out.

    Attributes
    ----------
    reason : str
        Why the last frame gave no window; empty if it gave one.
    repeated_frames : int
        How many frames were left out because they showed the one before once more.
    warnings : tuple of str
        What is wrong though there may be a window: frames that come twice, other lights that
        flash in step, pixels that clip below the saturation.
    finding : str
        What the flash mode found out about the light; empty if it was told all.
    in_view : collection of str
        Names of the lights that the last frame showed, also where its window is one of several
        looks that are still to be summed.

    Examples
    --------
    A light that is on in the even frames, in the virtual lab; the windows of its first flashes are
    kept back until it is known to flash:

    >>> from blob_tracker.simulation import flashing_light
    >>> scene, segmenter = flashing_light(width=160, height=120), Segmenter()
    >>> for index in range(9):
    ...     frame = Frame(scene.frame(index), scene.stamp_ns(index), saturation=255)
    ...     window = segmenter.update(frame)
    >>> window.x0, window.y0, window.lit.shape
    (83, 82, (15, 15))
    >>> segmenter.detections.state
    'locked'

    """

    def __init__(
        self,
        *,
        flash: Flash | None = None,
        threshold: Threshold | None = None,
        min_snr: float = 7.0,
        max_blob: int = 128,
        looks: int = 1,
        mask: NDArray[np.generic] | None = None,
        channel: ChannelChoice | None = None,
    ) -> None:
        self.flash = flash or InStep()
        self.channel = channel or ChannelChoice()
        self.threshold = threshold or threshold_by_name('sigma_window', sigmas=3.0, extension=2)
        self.min_snr = min_snr
        self.max_blob = max_blob
        self.in_view: Collection[str] = ()
        self._reason: str | tuple[float, float] = 'no frame yet'  # or noise and greatest rise, DN
        self._detections: Detections | None = None
        self._found_at_once: tuple[Shown, Frame, Frame] | None = None  # that it is made of
        # Of either frame the raw pixels, and where they are of one kind.
        self._unlit_pair: tuple[tuple[Pixels, Frame], tuple[Pixels, Frame]] | None = None
        self._unlit: Frame | None = None
        self._repeated = RepeatedFrames()
        self._region: tuple[int, int, int, int] = whole((0, 0))  # see `Box`
        self._stack = FrameStack(looks)
        self._flat_top = FlatTop()
        self._mask = NO_MASK if mask is None else np.ascontiguousarray(mask != 0, dtype=np.uint8)
        self._asked: Asked | None = None
        if looks == 1 and isinstance(self.threshold, partial) and (
            self.threshold.func is sigma_window
        ):
            self._asked = Asked(
                self._mask, min_snr, GATED_SNR_FRACTION * min_snr,
                self.threshold.keywords['sigmas'], max_blob,
            )

    @property
    def reason(self) -> str:
        """Why the last frame gave no window; empty if it gave one. It may be set."""
        return self._reason if isinstance(self._reason, str) else self._strongest(*self._reason)

    @reason.setter
    def reason(self, reason: str) -> None:
        self._reason = reason

    @property
    def unlit_pair(self) -> tuple[Pixels, Pixels] | None:
        """
        Return the raw pixels of the last two frames without a light.

        There are none where the last frame neither is one of them nor ended a block that holds
        them. What differs in them is noise, or moved.
        """
        if self._unlit_pair is None:
            return None
        first, second = self._unlit_pair
        return one_site(*first), one_site(*second)

    @property
    def repeated_frames(self) -> int:
        """How many frames were left out because they showed the one before once more."""
        return self._repeated.count

    @property
    def finding(self) -> str:
        """Return what the flash mode found out about the light; empty if it was told all."""
        return self.flash.finding

    @property
    def warnings(self) -> tuple[str, ...]:
        """Say what is wrong though there may be a window: of frames, other lights and clipping."""
        said = self._repeated.warning, self.flash.warning, self._flat_top.warning
        return tuple(filter(None, said)) if any(said) else ()

    def update(self, frame: Frame, expected: Expectation | None = None) -> Window | None:
        """
        Take the next frame; return the window of the light that it shows.

        Of several lights it is the first one. Arguments and errors are those of `sightings`.
        """
        found = self.sightings(frame, expected)
        return found[0].window if found else None

    def sightings(self, frame: Frame, expected: Expectation | None = None) -> list[Sighting]:
        """
        Take the next frame; return the lights that it shows.

        Parameters
        ----------
        frame : Frame
            The next frame of the same camera, grey or with colours.
        expected : Expectation, optional
            Where a tracker expects the light that is followed: it is looked for there first, and
            as without where it is not there. It is heeded where pairs of frames are compared, in
            the modes alternate and auto; the others search the whole frame in any case.

        Returns
        -------
        list of Sighting
            None, one, or one of each name; if it is empty, `reason` says why.

        Raises
        ------
        FrameError
            If the stamp is not later than the last one (that frame is left out), the stamps
            jumped back or the size, crop or depth changed (this frame starts afresh), the mask is
            of another size, the sum of the looks does not fit into 16 bits, or there is no such
            channel.

        """
        if self._mask is not NO_MASK and self._mask.shape != frame.image.shape[:2]:
            raise FrameError(
                f'the mask is {self._mask.shape[1]} x {self._mask.shape[0]} px and the frame '
                f'{frame.image.shape[1]} x {frame.image.shape[0]}; they must be of one size'
            )
        frame = plain(frame)
        self.in_view = ()
        if expected is None:
            found_at_once = self._at_once(frame)
            if found_at_once is not None:
                return found_at_once
        if self._repeated.push(frame):
            self.flash.skip(frame)
            self.reason = self._repeated.warning
            return []
        frame = self._in_channel(frame)
        before, self._unlit, self._unlit_pair = self._unlit, None, None
        contrast = self.flash.contrast(frame, expected)
        if contrast is None:
            self.reason = self.flash.reason
            return []
        contrast, found = self._search(contrast)
        while (wider := self.flash.widened(
            contrast, () if found.reason else found.candidates
        )) is not None:
            contrast, found = self._search(wider)
        sightings: list[Sighting] = []
        windows: dict[str, Box] = {}
        if found.reason:
            self.reason = self.flash.reason or found.reason
        else:
            chosen = self.flash.choose(contrast, found.candidates)
            self.reason = '' if chosen else self._reason_for_none(found)
            if self.flash.surveys:
                self._survey(contrast, found)
            for name, candidate in chosen:
                box = self._window(contrast, candidate)
                if box is None:
                    continue
                windows[name] = box
                window = self._stack.add(name, contrast, candidate, box)
                if window is None:
                    self.reason = self._stack.reason
                else:
                    window = self._flat_top.marked(window, candidate.noise)
                    sightings.append(Sighting(name, window))
        if sightings:
            self.reason = ''
        self.in_view = windows
        self._keep_unlit(frame, contrast, before, lit=bool(windows))
        self._found_at_once, self._detections = None, Detections(
            contrast.lit,
            contrast.unlit if contrast.unlit_frames else None,
            found.background,
            found.noise,
            Box(*self._region),
            found.candidates,
            windows,
            'locked' if self.flash.locked else 'lost',
            self.reason,
            self.warnings,
        )
        return sightings

    def _at_once(self, frame: Frame) -> list[Sighting] | None:
        """Return what `sightings` does of a frame that is as ever; None of any other."""
        before, flash = self._repeated.last, self.flash
        if (
            self._asked is None or before is None or type(flash) is not InStep
            or frame.layout != 'grey' or frame.mosaic is not None
            or frame.quantisation is not None or frame.raw_steps is not None
            or self.channel.channel != 'luma'
        ):
            return None
        answer = flash.at_once(frame, before, self._asked)
        if answer is None:
            return None
        found, glimpse = answer
        self._repeated.take(frame, found.noisy)
        self.channel.take(frame, None)
        self._region = found.region
        self._found_at_once = found, frame, before
        unlit, self._unlit_pair = self._unlit, None
        if not found.shown:
            self._pair_unlit(frame, unlit)
            self._reason = flash.reason or found.levels[1:]
            return []
        self._reason, self.in_view = '', ALONE
        window = cut_at_once(frame, found.box, found.lit, found.unlit, glimpse)
        return [Sighting('', self._flat_top.judged(window, found.table.item(0, NOISE), found.top))]

    @property
    def detections(self) -> Detections | None:
        """Return what was seen in the last frame that was compared with others."""
        if self._found_at_once is not None:
            found, frame, before = self._found_at_once
            level, noise, _ = found.levels
            self._found_at_once, self._detections = None, Detections(
                frame.image, before.image, level, noise, Box(*self._region),
                Candidates(found.table),
                {'': Box(*found.box)} if found.shown else {},
                'locked' if self.flash.locked else 'lost', self.reason, self.warnings,
            )
        return self._detections

    def _in_channel(self, frame: Frame) -> Frame:
        """Return the colour of a frame that is searched; begin afresh where it is another one."""
        has_colours = frame.layout != 'grey'
        region = Box(*self._region) if has_colours and self.flash.locked else None
        frame, before = self.channel.take(frame, region)
        if before is not None:
            self._unlit = None
            with suppress(FrameError):  # which says that it begins afresh with this one
                self.flash.contrast(before)
        return frame

    def _search(self, contrast: Contrast) -> tuple[Contrast, SearchResult]:
        """Return what lit up in the region in which the target can be, and what it is seen in."""
        self._region = region = self.flash.region(contrast)
        # Within the gate there is little room for chance.
        followed = 2 * region.size < contrast.lit.size and self.flash.locked
        min_snr = self.min_snr * (GATED_SNR_FRACTION if followed else 1.0)
        mask = self._mask_of(contrast)
        found = search(contrast, region, min_snr=min_snr, followed=followed, mask=mask)
        mended = without_black_cores(contrast, found.candidates)
        if mended is None:
            return contrast, found
        return mended, search(mended, region, min_snr=min_snr, followed=followed, mask=mask)

    def _mask_of(self, contrast: Contrast) -> NDArray[np.uint8]:
        """Return the mask of the pixels that are searched, which may be cells of a mosaic."""
        return self._mask if contrast.frame.mosaic is None else _of_cells(self._mask)

    def _survey(self, contrast: Contrast, found: SearchResult) -> None:
        """Show the flash mode what lit up outside of the region as well."""
        region = whole(contrast.shape)
        everything = found if self._region == region else search(
            contrast, region, min_snr=self.min_snr, mask=self._mask_of(contrast)
        )
        if not everything.reason:
            self.flash.survey(contrast, everything.candidates)

    def _keep_unlit(
        self, frame: Frame, contrast: Contrast, before: Frame | None, *, lit: bool
    ) -> None:
        """Pair this frame with the unlit one before it, or take the unlit ones of a block."""
        if len(contrast.unlit_frames) > 1:
            first, second = contrast.unlit_frames[-2:]
            self._unlit_pair = (first, frame), (second, frame)
        elif lit:
            self._unlit = before
        else:
            self._pair_unlit(frame, before)

    def _pair_unlit(self, frame: Frame, before: Frame | None) -> None:
        """Pair this frame, which is unlit, with the one before it that was."""
        self._unlit = frame
        if before is not None and frame.stamp_ns - before.stamp_ns <= MAX_UNLIT_INTERVAL_NS:
            self._unlit_pair = (before.samples, before), (frame.samples, frame)

    def _window(self, contrast: Contrast, candidate: Candidate) -> Box | None:
        """Return the window of the target, or None with the reason why there is none."""
        box = self.threshold(contrast, candidate, self.max_blob)
        most = 2 * self.max_blob + 1
        if box is None or box[2] - box[0] > most or box[3] - box[1] > most:
            self.reason = f'what lit up is not a blob of at most {most} px (max_blob)'
            return None
        if box.cut_through(*candidate.peak, contrast.shape):
            self.reason = "the target is cut by the frame's edge"
            return None
        return box

    def _reason_for_none(self, found: SearchResult) -> str:
        """Return why nothing was chosen."""
        if self.flash.reason:
            return self.flash.reason
        if found.candidates:
            return found.candidates[0].rejected
        return self._strongest(found.noise, found.strongest)

    def _strongest(self, noise: float, rise: float) -> str:
        """Say how strong a rise was, DN, where nothing lit up."""
        return (
            f'nothing lit up: the strongest rise is {rise:.0f} DN, {rise / noise:.1f} times the '
            f'noise; the SNR asked for in the matched filter is {self.min_snr:g} (min_snr)'
        )


def _of_cells(mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the mask of cells of 2 x 2 pixels: 0 where it is 0 in any of the four."""
    rows, columns = (size // 2 * 2 for size in mask.shape)
    whole = mask[:rows, :columns]
    return np.ascontiguousarray(
        whole[::2, ::2] & whole[::2, 1::2] & whole[1::2, ::2] & whole[1::2, 1::2]
    )

"""Frames in their order -> the windows of the targets, lit and unlit."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.segmentation.box import Box, box_about
from blob_tracker.segmentation.candidate import falls_beside, reject, suppress_connected
from blob_tracker.segmentation.difference import strongest_rise
from blob_tracker.segmentation.flash import Flash, Flashed
from blob_tracker.segmentation.look import Candidate, Look
from blob_tracker.segmentation.looks import FULL, sum_looks
from blob_tracker.segmentation.sigma_window import Extent, measure_extent
from blob_tracker.segmentation.thresholds import Threshold, threshold_by_name
from blob_tracker.types import Frame, Window
import cv2
import numpy as np
from numpy.typing import NDArray

MOST_CANDIDATES = 8  # peaks of a frame that are looked at, the highest first
SUPPRESSED = 6  # px about a peak that are its own flank, and as many sigma of its blob
SUPPRESSED_SIGMAS = 4.0
LARGEST_EXTENT = 64.0  # px of sigma: what is wider is no blob


class Sighting(NamedTuple):
    """
    A target in a frame.

    Parameters
    ----------
    name : str
        Which light it is; empty where there is only one.
    window : Window
        Its pixels.

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
    max_blob : int
        Greatest half-width of the blob's window, px.

    Attributes
    ----------
    reason : str
        Why the last frame gave no window; empty where it gave one.

    """

    def __init__(
        self,
        *,
        flash: Flash | None = None,
        threshold: Threshold | None = None,
        max_blob: int = 128,
        looks: int = 1,
        mask: NDArray[np.generic] | None = None,
    ) -> None:
        self.flash = flash or Alternate(min_snr=8.0, max_pair_interval=0.1)
        self.threshold = threshold or threshold_by_name('sigma_window', sigmas=3.0, extension=2)
        self.max_blob = max_blob
        self.looks = looks
        self.mask = mask
        self.reason = 'no frame yet'
        self.look: Look | None = None
        self._previous: Frame | None = None
        self._pairs: deque[Flashed] = deque(maxlen=looks)
        self._candidates: list[Candidate] = []

    def update(self, frame: Frame) -> Window | None:
        """
        Take the next frame; return the window of the light that it shows.

        Of several lights it is the first one. Arguments and errors are those of `sightings`.
        """
        found = self.sightings(frame)
        return found[0].window if found else None

    def sightings(self, frame: Frame) -> list[Sighting]:
        """
        Take the next frame; return the lights that it shows.

        Parameters
        ----------
        frame : Frame
            The next frame of the same camera.

        Returns
        -------
        list of Sighting
            None, one, or one of each name; where it is empty, `reason` says why.

        Raises
        ------
        FrameError
            Where the stamp is not later than the last one (that frame is left out), or the stamps
            jumped back or the size, crop or depth changed (this frame starts afresh).

        """
        found: list[Sighting] = []
        boxes: dict[str, Box] = {}
        unlit, self._previous = self._previous, frame
        self._candidates = []
        flashes = self.flash.update(frame)
        reason = '' if flashes else self.flash.reason
        for flashed in flashes:
            if self.mask is not None and flashed.search is not None:
                flashed.search[self.mask == 0] = 0
            box, why = self._choose(flashed)
            if box is None:
                reason = why
                continue
            boxes[flashed.name] = box
            if self.looks > 1:
                self._pairs.append(flashed)
                if len(self._pairs) < self.looks:
                    reason = f'look {len(self._pairs)} of {self.looks}'
                    continue
                flashed = flashed._replace(
                    lit=tuple(image for each in self._pairs for image in each.lit),
                    unlit=tuple(image for each in self._pairs for image in each.unlit),
                )
                self._pairs.clear()
            found.append(Sighting(flashed.name, _cut(flashed, box)))
        self.reason = '' if found else reason
        contrast = flashes[0].contrast if flashes else None
        height, width = frame.image.shape
        if contrast is None and unlit is not None and unlit.image.shape != frame.image.shape:
            unlit = None
        self.look = Look(
            lit=contrast.lit if contrast else frame.image,
            unlit=contrast.unlit if contrast else unlit.image if unlit else None,
            background=contrast.background if contrast else 0.0,
            noise=contrast.noise if contrast else strongest_rise(
                frame.image, unlit.image if unlit else frame.image
            ).noise,
            region=Box(0, 0, width, height),
            candidates=tuple(self._candidates),
            windows=boxes,
            state='lost',
            reason=self.reason,
        )
        return found

    def _choose(self, flashed: Flashed) -> tuple[Box | None, str]:
        """
        Return the window of the strongest peak that can be the target, or else why none can.

        Of several that can be, the strongest is that of the greatest matched-filter SNR. The
        reason is that of the highest peak.
        """
        best, best_snr, reason = None, 0.0, ''
        column, row, height = flashed.column, flashed.row, flashed.height
        for _ in range(MOST_CANDIDATES):
            extent = measure_extent(flashed.contrast, column, row, LARGEST_EXTENT)
            box, why = self._window(flashed, extent, column, row, height)
            if self.mask is not None and not self.mask[row, column]:
                box, why = None, 'masked'
            reason = reason or why
            if extent is not None:
                self._candidates.append(Candidate(*extent, height, why))
            if box is not None and extent is not None and extent.snr > best_snr:
                best, best_snr = box, extent.snr
            if flashed.search is None:
                break
            half = SUPPRESSED
            if extent is not None:
                half = max(half, int(np.ceil(SUPPRESSED_SIGMAS * extent.sigma_major)))
            if box is None:
                suppress_connected(flashed.search, column, row, flashed.least)
            flashed.search[box_about(column, row, half, half, flashed.contrast.shape).slices] = 0
            _, height, _, (column, row) = cv2.minMaxLoc(flashed.search)
            if height < flashed.least:
                break
        return best, reason

    def _window(
        self, flashed: Flashed, extent: Extent | None, column: int, row: int, height: float
    ) -> tuple[Box | None, str]:
        """Return the window of a peak, or None and why it is not the target."""
        contrast = flashed.contrast
        why = reject(contrast, extent, column, row, height, flashed.frame.saturation)
        if why:
            return None, why
        if extent is not None and extent.snr < flashed.min_snr:
            return None, (
                f'nothing lit up: the strongest rise has an SNR of {extent.snr:.1f} in the '
                f'matched filter (min_snr {flashed.min_snr:g})'
            )
        box = self.threshold(contrast, column, row, self.max_blob)
        if box is None or max(box.x1 - box.x0, box.y1 - box.y0) > 2 * self.max_blob + 1:
            return None, (
                f'what lit up is no blob of at most {2 * self.max_blob + 1} px (max_blob)'
            )
        if box.cut_through(column, row, contrast.shape):
            return None, "the target is cut by the frame's edge"
        why = falls_beside(contrast, box, column, row, height)
        return (None, why) if why else (box, '')


def _cut(flashed: Flashed, box: Box) -> Window:
    """Return the raw pixels of a box."""
    frame = flashed.frame
    several = len(flashed.lit) > 1
    lit, unlit = (
        [image[box.slices] for image in images] for images in (flashed.lit, flashed.unlit)
    )
    bin_x, bin_y = frame.binning
    return Window(
        lit=sum_looks(lit, frame.saturation),
        unlit=sum_looks(unlit, frame.saturation) if unlit else None,
        x0=frame.x0 + bin_x * box.x0,
        y0=frame.y0 + bin_y * box.y0,
        stamp_ns=frame.stamp_ns,
        saturation=FULL if several else frame.saturation,
        binning=frame.binning,
        looks=len(flashed.lit),
    )

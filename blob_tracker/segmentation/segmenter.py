"""Frames in their order -> the windows of the targets, lit and unlit."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.segmentation.box import box_about
from blob_tracker.segmentation.flash import Flash, Flashed
from blob_tracker.segmentation.looks import FULL, sum_looks
from blob_tracker.segmentation.thresholds import Threshold, threshold_by_name
from blob_tracker.types import Frame, Window

# Two lit frames of a moving light leave a rise and an equal fall beside each other; a true flash
# leaves no fall but noise. Half-way between the two tells them apart.
LARGEST_FALL = 0.5
NOISE_FALL = 6.0  # standard deviations; no pixel of a window falls so far by noise alone


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
    ) -> None:
        self.flash = flash or Alternate(min_snr=7.0, max_pair_interval=0.1)
        self.threshold = threshold or threshold_by_name('sigma_window', sigmas=3.0, extension=2)
        self.max_blob = max_blob
        self.reason = 'no frame yet'

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
        found = []
        flashes = self.flash.update(frame)
        reason = '' if flashes else self.flash.reason
        for flashed in flashes:
            window, why = self._cut(flashed)
            if window is None:
                reason = why
            else:
                found.append(Sighting(flashed.name, window))
        self.reason = '' if found else reason
        return found

    def _cut(self, flashed: Flashed) -> tuple[Window | None, str]:
        """Return the window of a light if it can be the target's, or else why not."""
        contrast, frame = flashed.contrast, flashed.frame
        box = self.threshold(contrast, flashed.column, flashed.row, self.max_blob)
        if box is None or max(box.x1 - box.x0, box.y1 - box.y0) > 2 * self.max_blob + 1:
            return None, (
                f'what lit up is no blob of at most {2 * self.max_blob + 1} px (max_blob)'
            )
        if box.cut_through(flashed.column, flashed.row, contrast.shape):
            return None, "the target is cut by the frame's edge"
        if contrast.unlit is not None:
            reach = max(box.x1 - box.x0, box.y1 - box.y0)
            about = box_about(flashed.column, flashed.row, reach, reach, contrast.shape)
            fall = -float(contrast.signal(about).min())
            if fall > max(LARGEST_FALL * flashed.height, NOISE_FALL * contrast.noise):
                return None, (
                    f'a rise of {flashed.height:.0f} DN beside a fall of {fall:.0f} DN: '
                    'something moved, or the light was on in both frames'
                )
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
        ), ''

"""Frames in their order -> the window of the target, lit and unlit."""

from __future__ import annotations

from blob_tracker.segmentation.box import box_about, scaled
from blob_tracker.segmentation.difference import signed_difference, strongest_rise
from blob_tracker.segmentation.otsu import otsu_window
from blob_tracker.types import Frame, Window

SMALLEST_WINDOW = 7  # px: room for a blob of sigma 1 and its background
# Two lit frames of a moving light leave a rise and an equal fall beside each other; a true flash
# leaves no fall but noise. Half-way between the two tells them apart.
LARGEST_FALL = 0.5


class FrameError(ValueError):
    """A frame that cannot follow the one before it; the message says why."""


class Segmenter:
    """
    Find a light that is on in every other frame.

    Each frame is compared with the one before it. Where a pixel rose by more than the noise can,
    the frame is the lit one and its neighbour the unlit one; where light went out, or nothing
    changed, there is no target in that frame. So the phase of the flash need not be known, and a
    dropped or repeated frame costs its own pair and no more.

    Parameters
    ----------
    min_snr : float
        Least rise, in standard deviations of a difference pixel.
    max_pair_interval : float
        Greatest time between the two frames of a pair, s.
    window_scale : float
        Width of the window that is cut out, in widths of the thresholded blob. Otsu's threshold
        leaves the tails outside (thesis, section 5.5), which the location needs.
    max_blob : int
        Greatest half-width in which the blob is looked for, px.

    Attributes
    ----------
    reason : str
        Why the last frame gave no window; empty where it gave one.

    """

    def __init__(
        self,
        *,
        min_snr: float = 7.0,
        max_pair_interval: float = 0.1,
        window_scale: float = 2.0,
        max_blob: int = 64,
    ) -> None:
        self.min_snr = min_snr
        self.max_pair_interval = max_pair_interval
        self.window_scale = window_scale
        self.max_blob = max_blob
        self.reason = 'no frame yet'
        self._previous: Frame | None = None

    def update(self, frame: Frame) -> Window | None:
        """
        Compare the next frame with the one before it.

        Parameters
        ----------
        frame : Frame
            The next frame of the same camera.

        Returns
        -------
        Window or None
            The target in this frame and in the unlit one before it, or None: see `reason`.

        Raises
        ------
        FrameError
            Where the stamp is not later than the last one (that frame is left out), or the stamps
            jumped back or the size, crop or depth changed (this frame starts afresh).

        """
        previous = self._previous
        if previous is not None and frame.stamp_ns <= previous.stamp_ns:
            late = (previous.stamp_ns - frame.stamp_ns) / 1e9
            if late > self.max_pair_interval:
                self._previous = frame
                raise FrameError(f'the stamps jumped back by {late:.3f} s; starting afresh')
            kind = 'repeated' if late == 0.0 else f'{late:.3f} s older than the one before'
            raise FrameError(f'frame left out: its stamp is {kind}; stamps must grow')
        self._previous = frame
        if previous is None:
            self.reason = 'waiting for a second frame'
            return None
        if _geometry(frame) != _geometry(previous):
            raise FrameError(
                f'the frames changed from {_describe(previous)} to {_describe(frame)}; '
                'starting afresh'
            )
        interval = (frame.stamp_ns - previous.stamp_ns) / 1e9
        if interval > self.max_pair_interval:
            self.reason = (
                f'frames {interval:.3f} s apart; a pair may be at most '
                f'{self.max_pair_interval:.3f} s apart (max_pair_interval)'
            )
            return None
        return self._cut(frame, previous)

    def _cut(self, lit: Frame, unlit: Frame) -> Window | None:
        """Return the window of the strongest rise, if it can be the target's."""
        peak = strongest_rise(lit.image, unlit.image)
        if peak.height < self.min_snr * peak.noise:
            self.reason = (
                f'nothing lit up: the strongest rise is {peak.height:.0f} DN, '
                f'{peak.height / peak.noise:.1f} times the noise (min_snr {self.min_snr:g})'
            )
            return None
        blob = otsu_window(peak.image, peak.column, peak.row, self.max_blob)
        shape = lit.image.shape
        reach = max(blob.x1 - blob.x0, blob.y1 - blob.y0)
        if reach > 2 * self.max_blob:
            self.reason = f'what lit up is larger than {2 * self.max_blob} px (max_blob)'
            return None
        if blob.touches_edge(shape):
            self.reason = "the target is cut by the frame's edge"
            return None
        box = scaled(blob, self.window_scale, SMALLEST_WINDOW, shape)
        about = box_about(peak.column, peak.row, 2 * reach, 2 * reach, shape)
        fall = -signed_difference(lit.image[about.slices], unlit.image[about.slices]).min()
        if fall > LARGEST_FALL * peak.height and fall > self.min_snr * peak.noise:
            self.reason = (
                f'a rise of {peak.height:.0f} DN beside a fall of {fall:.0f} DN: '
                'something moved, or the light was on in both frames'
            )
            return None
        self.reason = ''
        bin_x, bin_y = lit.binning
        return Window(
            lit=lit.image[box.slices],
            unlit=unlit.image[box.slices],
            x0=lit.x0 + bin_x * box.x0,
            y0=lit.y0 + bin_y * box.y0,
            stamp_ns=lit.stamp_ns,
            saturation=lit.saturation,
            binning=lit.binning,
        )


def _geometry(frame: Frame) -> tuple[object, ...]:
    """Return what two frames must share for their pixels to be comparable."""
    return frame.image.shape, frame.image.dtype, frame.x0, frame.y0, frame.binning


def _describe(frame: Frame) -> str:
    """Return the frame's size and place in words."""
    height, width = frame.image.shape
    return (
        f'{width} x {height} {frame.image.dtype} at ({frame.x0}, {frame.y0}) '
        f'binned {frame.binning[0]} x {frame.binning[1]}'
    )

"""The last frames of one camera, in their order."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from statistics import median

from blob_tracker.types import Frame, Pixels
import numpy as np

LEAST_INTERVAL_S = 0.1  # s: frames that are nearer may follow each other, whatever the rate
LONGEST_INTERVAL = 1.5  # frame intervals: less than two, which a lost frame leaves
INTERVALS, ENOUGH = 9, 3  # of the last frames: kept, and needed to know the frame rate


class FrameError(ValueError):
    """
    A frame that cannot follow the one before it; the message says why.

    Examples
    --------
    A frame that was taken before the last one:

    >>> from blob_tracker.segmentation import Segmenter
    >>> segmenter, image = Segmenter(), np.zeros((48, 64), np.uint8)
    >>> segmenter.update(Frame(image, stamp_ns=16_666_667, saturation=255))
    >>> segmenter.update(Frame(image, stamp_ns=0, saturation=255))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.segmentation.history.FrameError: ...stamp is 0.017 s older than the one before...

    """


class FrameHistory:
    """
    Keep the last frames, all of one size and not too far apart.

    Parameters
    ----------
    length : int
        How many.
    max_interval : float
        Greatest time from one frame to the next, s; 0 follows the frame rate: `LEAST_INTERVAL_S`,
        or for a slower camera `LONGEST_INTERVAL` times the median of the last intervals.

    """

    def __init__(self, length: int, max_interval: float) -> None:
        self._max_interval = max_interval
        self._intervals: deque[float] = deque(maxlen=INTERVALS)
        self.frames: deque[Frame] = deque(maxlen=length)

    @property
    def max_interval(self) -> float:
        """Return the greatest time from one frame to the next, s, as it is now."""
        if self._max_interval:
            return self._max_interval
        if len(self._intervals) < ENOUGH:
            return LEAST_INTERVAL_S
        return max(LEAST_INTERVAL_S, LONGEST_INTERVAL * median(self._intervals))

    def push(self, frame: Frame) -> float | None:
        """
        Take the next frame.

        Parameters
        ----------
        frame : Frame
            The next frame of the same camera.

        Returns
        -------
        float or None
            Time since the frame before it, s; None for the first one. Where it is more than
            `max_interval`, all frames before this one are forgotten.

        Raises
        ------
        FrameError
            If the stamp is not later than the last one (that frame is left out), or the stamps
            jumped back or the channel, size, crop or depth changed (this frame starts afresh).

        """
        frame = plain(frame)
        if not self.frames:
            self.frames.append(frame)
            return None
        previous = self.frames[-1]
        if frame.channel != previous.channel:  # an earlier frame may come again, in another one
            self._restart(frame)
            raise FrameError(
                f'the channel changed from {previous.channel} to {frame.channel}; starting again'
            )
        if frame.stamp_ns <= previous.stamp_ns:
            late = (previous.stamp_ns - frame.stamp_ns) / 1e9
            if late > self.max_interval:
                self._restart(frame)
                raise FrameError(f'the stamps jumped back by {late:.3f} s; starting again')
            kind = 'repeated' if late == 0.0 else f'{late:.3f} s older than the one before'
            if frame.stamp_ns == previous.stamp_ns == 0:
                kind = '0 like that before: whoever takes the images has to stamp each'
            raise FrameError(f'frame left out: its stamp is {kind}; stamps must grow')
        if not _alike(frame, previous):
            self._restart(frame)
            raise FrameError(
                f'the frames changed from {" to ".join(_described(previous, frame))}; starting '
                'again'
            )
        interval = (frame.stamp_ns - previous.stamp_ns) / 1e9
        self._intervals.append(interval)
        if self._is_gap(interval):
            self.frames.clear()
        self.frames.append(frame)
        return interval

    def take(self, frame: Frame, interval: float) -> None:
        """Take a frame that goes on, so long after the last one, s."""
        self._intervals.append(interval)
        self.frames.append(frame)

    def goes_on(self, last: Frame, frame: Frame) -> bool:
        """Tell whether a frame can be taken after this one, which is the last, without a gap."""
        interval_ns = frame.stamp_ns - last.stamp_ns
        return (
            bool(self.frames) and last is self.frames[-1] and interval_ns > 0
            and frame.channel == last.channel and _alike(frame, last)
            and not self._is_gap(interval_ns / 1e9)
        )

    def _is_gap(self, interval: float) -> bool:
        """Tell whether a time is more than `max_interval`, which takes a median to know."""
        return interval > (self._max_interval or LEAST_INTERVAL_S) and interval > self.max_interval

    def _restart(self, frame: Frame) -> None:
        self._intervals.clear()
        self.frames.clear()
        self.frames.append(frame)


def plain(frame: Frame) -> Frame:
    """Return the frame with pixels that the kernels take: they are compiled for no others."""
    mosaic = frame.mosaic
    if mosaic is not None and not _is_plain(mosaic.pixels):
        frame = replace(frame, mosaic=replace(mosaic, pixels=np.array(mosaic.pixels, order='C')))
    return frame if _is_plain(frame.image) else replace(
        frame, image=np.array(frame.image, order='C')
    )


def _is_plain(pixels: Pixels) -> bool:
    """Tell whether pixels lie one after the other in memory, and may be written."""
    flags = pixels.flags
    return flags.c_contiguous and flags.writeable


def _alike(one: Frame, other: Frame) -> bool:
    """Tell whether the pixels of two frames are comparable."""
    return (
        one.image.shape == other.image.shape and one.image.dtype == other.image.dtype
        and one.x0 == other.x0 and one.y0 == other.y0 and one.binning == other.binning
    )


def _described(*frames: Frame) -> Iterator[str]:
    """Return size and type of each frame; of where it lies on the sensor only what differs."""
    corners = len({(frame.x0, frame.y0) for frame in frames}) > 1
    binnings = len({frame.binning for frame in frames}) > 1
    for frame in frames:
        height, width = frame.image.shape
        yield (
            f'{width} x {height} px ({frame.image.dtype})'
            + (f' at ({frame.x0}, {frame.y0})' if corners else '')
            + (' binned {} x {}'.format(*frame.binning) if binnings else '')
        )

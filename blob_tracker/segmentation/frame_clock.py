"""The time that a camera's stamps tell, in frames: how old a track is, and whether in step."""

from __future__ import annotations

from collections import deque
import math

from blob_tracker.segmentation.flash_track import FlashTrack, PERIOD_FRAMES

INTERVALS = 9  # of the last frames, whose median is the time between frames
STAMP_TOLERANCE_FRAMES = 0.25  # frames by which a stamp may be off and still tell even from odd


class FrameClock:
    """
    Count the frames by their stamps, those that were lost among them.

    Attributes
    ----------
    stamp_ns : int or None
        Stamp of the last frame, ns; None before the first.
    frame : float
        Its number.

    """

    def __init__(self) -> None:
        self.stamp_ns: int | None = None
        self.frame = 0.0
        self._intervals: deque[int] = deque(maxlen=INTERVALS)
        self._interval_ns = 0.0  # their median
        self._skipped_ns: int | None = None  # stamp of the last frame that came twice

    def push(self, stamp_ns: int) -> None:
        """Take the stamp of the next frame, ns."""
        if self.stamp_ns is not None:
            since_ns = stamp_ns - self.stamp_ns
            self._intervals.append(since_ns)
            ordered = sorted(self._intervals)
            middle = len(ordered) // 2
            self._interval_ns = 0.5 * (ordered[middle] + ordered[-1 - middle])
            self.frame += round(since_ns / self._interval_ns) or 1
        self.stamp_ns = stamp_ns

    def skip(self, stamp_ns: int) -> None:
        """
        Take note of a frame that showed the one before it once more, by its stamp, ns.

        It may stand for a frame that was lost, or be one too many, as where 24 frames a second are
        made 30: the stamps no longer tell in which phase a light is that was seen before it.
        """
        self._skipped_ns = stamp_ns

    def stamp_before(self, frames: int) -> float:
        """Return the stamp so many frames ago, ns; minus infinity where their time is not known."""
        if self.stamp_ns is None or self._interval_ns <= 0.0:
            return -math.inf
        return self.stamp_ns - frames * self._interval_ns

    @property
    def interval(self) -> float:
        """Return the time from frame to frame, the median of the last ones, s."""
        return self._interval_ns / 1e9

    def age(self, track: FlashTrack) -> float:
        """Return the time since a track was seen, in frames."""
        if self.stamp_ns is None or self._interval_ns <= 0.0:
            return 0.0
        return (self.stamp_ns - track.stamp_ns) / self._interval_ns

    def is_now(self, track: FlashTrack) -> bool:
        """Tell whether a track was seen in this frame."""
        return track.stamp_ns == self.stamp_ns

    def is_due(self, track: FlashTrack) -> bool:
        """Tell whether a track may have flashed again."""
        return self.age(track) >= PERIOD_FRAMES - STAMP_TOLERANCE_FRAMES

    def is_phase_unknown(self, track: FlashTrack) -> bool:
        """Tell whether a frame came twice since a track was seen."""
        return self._skipped_ns is not None and track.stamp_ns < self._skipped_ns

    def in_step(self, track: FlashTrack) -> bool:
        """Tell whether a light that flashes in step can be on again in this frame."""
        age = self.age(track)
        frames = round(age)
        if self.is_phase_unknown(track):
            return frames >= PERIOD_FRAMES
        return abs(age - frames) > STAMP_TOLERANCE_FRAMES or frames % PERIOD_FRAMES == 0

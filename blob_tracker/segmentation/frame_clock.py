"""The time that a camera's stamps tell, in frames: how old a track is, and whether in step."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.tile_noise import median
import numpy as np

PERIOD_FRAMES = 2  # frames from one flash to the next
INTERVALS = 9  # of the last frames, whose median is the time between frames
STAMP_TOLERANCE_FRAMES = 0.25  # frames by which a stamp may be off and still tell even from odd
# Places in a clock: stamp of the last frame, median of the intervals, ns; number of that frame;
# stamp of the last frame that came twice, ns; how many intervals there were, and the last of them.
STAMP, INTERVAL, FRAME, SKIPPED, COUNT, FIRST = range(6)


class FrameClock:
    """
    Count the frames by their stamps, those that were lost among them.

    Attributes
    ----------
    values : (15,) array
        What the kernels take: the places as above. Stamps are from the first one on, so that they
        are exact for a hundred days.

    """

    def __init__(self) -> None:
        self.values = np.zeros(FIRST + INTERVALS)
        self.values[STAMP] = self.values[SKIPPED] = -math.inf
        self._first_ns: int | None = None

    def since_first(self, stamp_ns: int) -> float:
        """Return a stamp as the kernels have it."""
        if self._first_ns is None:
            self._first_ns = stamp_ns
        return float(stamp_ns - self._first_ns)

    def skip(self, stamp_ns: int) -> None:
        """
        Take note of a frame that showed the one before it once more, by its stamp, ns.

        It may stand for a frame that was lost, or be one too many, as where 24 frames a second are
        made 30: the stamps no longer tell in which phase a light is that was seen before it.
        """
        self.values[SKIPPED] = self.since_first(stamp_ns)

    @property
    def stamp(self) -> float:
        """Return the stamp of the last frame as the kernels have it."""
        return self.values.item(STAMP)

    @property
    def frame(self) -> float:
        """Return the number of the last frame."""
        return self.values.item(FRAME)

    @property
    def interval(self) -> float:
        """Return the time from frame to frame, the median of the last ones, s."""
        return self.values.item(INTERVAL) / 1e9


@kernel
def tick(clock: Array, stamp: float) -> None:
    """Take the stamp of the next frame."""
    if clock[STAMP] > -np.inf:
        since = stamp - clock[STAMP]
        count = int(clock[COUNT])
        clock[FIRST + count % INTERVALS] = since
        clock[COUNT] = count + 1
        known = min(count + 1, INTERVALS)
        clock[INTERVAL] = median(clock[FIRST:FIRST + known].copy(), known)
        clock[FRAME] += max(np.rint(since / clock[INTERVAL]), 1.0)
    clock[STAMP] = stamp


@kernel
def stamp_before(clock: Array, frames: float) -> float:
    """Return the stamp so many frames ago; minus infinity where their time is not known."""
    if clock[INTERVAL] <= 0.0:
        return -np.inf
    return clock[STAMP] - frames * clock[INTERVAL]


@kernel
def age_of(clock: Array, stamp: float) -> float:
    """Return the time since a stamp, in frames."""
    if clock[INTERVAL] <= 0.0:
        return 0.0
    return (clock[STAMP] - stamp) / clock[INTERVAL]


@kernel
def is_due(clock: Array, stamp: float) -> bool:
    """Tell whether what was seen at a stamp may have flashed again."""
    return age_of(clock, stamp) >= PERIOD_FRAMES - STAMP_TOLERANCE_FRAMES


@kernel
def is_phase_unknown(clock: Array, stamp: float) -> bool:
    """Tell whether a frame came twice since a stamp."""
    return stamp < clock[SKIPPED]


@kernel
def in_step(clock: Array, stamp: float) -> bool:
    """Tell whether a light that flashes in step, seen at a stamp, can be on in this frame."""
    age = age_of(clock, stamp)
    frames = np.rint(age)
    if is_phase_unknown(clock, stamp):
        return frames >= PERIOD_FRAMES
    return abs(age - frames) > STAMP_TOLERANCE_FRAMES or int(frames) % PERIOD_FRAMES == 0


@kernel
def is_complete(clock: Array, stamp: float) -> bool:
    """Tell whether no frame was lost since a stamp, as far as the last intervals are known."""
    count = int(clock[COUNT])
    since, frames = 0.0, 0
    while frames < min(count, INTERVALS) and since < clock[STAMP] - stamp:
        frames += 1
        since += clock[FIRST + (count - frames) % INTERVALS]
    return frames >= np.rint(age_of(clock, stamp))

"""Which camera_info belongs to an image: that of its stamp, or of the nearest. No ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

NEAR = 0.5  # of the least interval of the images: beyond it another image is nearer
LATELY = 10  # intervals


class Nearness:
    """
    Tell which of two stamps are those of one image.

    Some drivers stamp image and camera_info one after the other: the nearest does as well, within
    `NEAR` of the least interval that the last images had.
    """

    def __init__(self) -> None:
        self._newest_ns: int | None = None  # of the images
        self._intervals: deque[int] = deque(maxlen=LATELY)  # ns

    @property
    def tolerance_ns(self) -> float:
        """How far the stamps of a pair may be apart, ns; 0 until two images have come."""
        return NEAR * min(self._intervals, default=0)

    def image(self, stamp_ns: int) -> None:
        """Take note of the stamp of the next image, ns."""
        if self._newest_ns is not None:
            if stamp_ns > self._newest_ns:
                self._intervals.append(stamp_ns - self._newest_ns)
            elif stamp_ns < self._newest_ns:
                self._intervals.clear()
        self._newest_ns = stamp_ns

    def is_near(self, offset_ns: int) -> bool:
        """Tell whether stamps that are so far apart, ns, are of one pair."""
        return offset_ns == 0 or abs(offset_ns) < self.tolerance_ns


def nearest(stamps: Iterable[int], stamp_ns: int) -> int:
    """Return that of some stamps which is the nearest to another, ns; one is there."""
    return min(stamps, key=lambda each: abs(each - stamp_ns))

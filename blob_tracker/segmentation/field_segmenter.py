"""Fields in their order -> the windows of the targets: each field beside the last of its kind."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.segmenter import Segmenter, Sighting
from blob_tracker.types import Frame, Pixels, Window

MOST = 2  # kinds of fields


class FieldSegmenter:
    """
    Find the lights that flash in the fields of an interlaced camera.

    The lines of the two fields lie between each other, and none of one can be compared with one of
    the other: the fields of a kind, told by their `y0`, have a segmenter of their own, which sees
    them at the rate of the pictures. A light in step with the pictures is on in both fields of one
    and off in those of the next, and gives two windows for each; one that runs free is seen by
    either. One in step with the fields would be on in all of a kind, and does not flash in them.

    Parameters
    ----------
    new_segmenter : callable
        Makes a segmenter.

    Attributes
    ----------
    reason : str
        Why the last field gave no window; empty where it gave one.
    unlit_pair : (array, array) or None
        As that of `Segmenter`, of the last field's kind.

    """

    def __init__(self, new_segmenter: Callable[[], Segmenter]) -> None:
        self.reason = 'no frame yet'
        self.unlit_pair: tuple[Pixels, Pixels] | None = None
        self._new_segmenter = new_segmenter
        self._of_kind: dict[int, Segmenter] = {}

    def update(self, frame: Frame, expected: Expectation | None = None) -> Window | None:
        """Take the next field; return the window of the light that it shows: see `Segmenter`."""
        found = self.sightings(frame, expected)
        return found[0].window if found else None

    def sightings(self, frame: Frame, expected: Expectation | None = None) -> list[Sighting]:
        """Take the next field; return the lights that it shows: see `Segmenter`."""
        if frame.y0 not in self._of_kind:
            if len(self._of_kind) == MOST:
                self._of_kind.clear()  # the crop is another one
            self._of_kind[frame.y0] = self._new_segmenter()
        segmenter = self._of_kind[frame.y0]
        found = segmenter.sightings(frame, expected)
        self.reason, self.unlit_pair = segmenter.reason, segmenter.unlit_pair
        return found

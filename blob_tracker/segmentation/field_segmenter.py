"""Frames and fields in their order -> the windows of the targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from blob_tracker.segmentation.channel import ChannelChoice
from blob_tracker.segmentation.detections import Detections
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.segmenter import Segmenter, Sighting
from blob_tracker.types import Frame, Pixels, Window


class FieldSegmenter:
    """
    Find the lights that flash, in frames as `Segmenter` does, and in the fields of pictures.

    The lines of the two fields lie between each other, and none of one can be compared with one of
    the other: each kind, told by its binning and `y0`, has a segmenter of its own, which sees its
    fields at the rate of the pictures. A light in step with the pictures is on in both fields of
    one and off in those of the next, and gives two windows for each; one that runs free is seen by
    either. One in step with the fields would be on in all of a kind, and does not flash in them.

    Parameters
    ----------
    new_segmenter : callable
        Makes a segmenter.
    of_kind : mapping of int to Segmenter, optional
        Those to go on with: 0 of frames and top fields, 1 of bottom fields.

    Attributes
    ----------
    of_kind : dict of int to Segmenter
        Those that there are.

    """

    def __init__(
        self, new_segmenter: Callable[[], Segmenter],
        of_kind: Mapping[int, Segmenter] | None = None,
    ) -> None:
        self._new_segmenter = new_segmenter
        self.of_kind = dict(of_kind or {})
        # Also of no kind yet: of its frames nothing is known, but what it is set to.
        self._last = next(iter(self.of_kind.values()), None) or new_segmenter()

    @property
    def channel(self) -> ChannelChoice:
        """Which colour is searched, in frames like the last one."""
        return self._last.channel

    @property
    def reason(self) -> str:
        """Why the last frame gave no window; empty where it gave one. It may be set."""
        return self._last.reason

    @reason.setter
    def reason(self, reason: str) -> None:
        self._last.reason = reason

    @property
    def detections(self) -> Detections | None:
        """Return what was seen in the last frame, see `Segmenter`."""
        return self._last.detections

    @property
    def warnings(self) -> tuple[str, ...]:
        """Say what is wrong though there may be a window, see `Segmenter`."""
        return self._last.warnings

    @property
    def finding(self) -> str:
        """Return what the flash mode found out about the light, see `Segmenter`."""
        return self._last.finding

    @property
    def unlit_pair(self) -> tuple[Pixels, Pixels] | None:
        """Raw pixels of the last two frames without a light, see `Segmenter`."""
        return self._last.unlit_pair

    @property
    def repeated_frames(self) -> int:
        """How many frames were left out because they showed the one before once more."""
        return sum(each.repeated_frames for each in self.of_kind.values())

    def update(self, frame: Frame, expected: Expectation | None = None) -> Window | None:
        """Take the next frame; return the window of the light that it shows: see `Segmenter`."""
        found = self.sightings(frame, expected)
        return found[0].window if found else None

    def sightings(self, frame: Frame, expected: Expectation | None = None) -> list[Sighting]:
        """Take the next frame; return the lights that it shows: see `Segmenter`."""
        kind = frame.field or 0
        if kind not in self.of_kind:
            self.of_kind[kind] = self._new_segmenter() if self.of_kind else self._last
        self._last = self.of_kind[kind]
        return self._last.sightings(frame, expected)

"""Frames and fields in their order -> the windows of the targets."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

from blob_tracker.segmentation.auto import Auto
from blob_tracker.segmentation.channel import ChannelChoice
from blob_tracker.segmentation.detections import Detections
from blob_tracker.segmentation.expectation import Expectation, GATE_SIGMA
from blob_tracker.segmentation.field_pairs import FieldPairs
from blob_tracker.segmentation.history import FrameError
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.segmentation.segmenter import Segmenter, Sighting
from blob_tracker.types import Frame, Pixels, Window
import numpy as np


PATIENCE_FIELDS = 24  # without a light in either kind, before neighbours are compared
FLASH_FIELDS = 4  # of two pictures, one lit and one not
MOST_AGE = 16  # fields, after which a light that was seen is not that of the other kind any more
WITH_FIELDS = (
    'on in every other field; the scene behind it is subtracted if it is on in both fields of '
    'every other picture'
)


class _Seen(NamedTuple):
    """Where a kind has seen its light, px of the full sensor and px a field; when, since when."""

    x: float
    y: float
    velocity_x: float
    velocity_y: float
    field: int
    since: int


class FieldSegmenter:
    """
    Find the lights that flash, in frames as `Segmenter` does, and in the fields of pictures.

    The lines of the two fields lie between each other, and none of one can be compared with one of
    the other: each kind, told by its binning and `y0`, has a segmenter of its own, which sees its
    fields at the rate of the pictures. A light in step with the pictures is on in both fields of
    one and off in those of the next, and gives two windows for each; one that runs free is seen by
    either. One in step with the fields is on in all of a kind, and does not flash in them: where
    neither kind has a light for a while, each field is compared with the one before it, too
    (`FieldPairs`). Of several lights in step both kinds follow the one that either has seen for
    longer.

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

    Examples
    --------
    Each of the two kinds of fields of an analogue camera has a segmenter:

    >>> from blob_tracker.capture.fields import fields
    >>> from blob_tracker.segmentation import Segmenter
    >>> from blob_tracker.simulation import InterlacedCamera, Scene
    >>> camera = InterlacedCamera(Scene(width=160, height=120))
    >>> segmenter = FieldSegmenter(Segmenter)
    >>> for field in fields(camera.picture(0), camera.order, camera.interval_ns):
    ...     _ = segmenter.update(field)
    >>> sorted(segmenter.of_kind)
    [0, 1]

    """

    def __init__(
        self, new_segmenter: Callable[[], Segmenter],
        of_kind: Mapping[int, Segmenter] | None = None,
    ) -> None:
        self._new_segmenter = new_segmenter
        self.of_kind = dict(of_kind or {})
        # Also of no kind yet: of its frames nothing is known, but what it is set to.
        self._last = next(iter(self.of_kind.values()), None) or new_segmenter()
        self._fruitless = 0  # fields in a row without a light in their kind
        self._pairs: FieldPairs | None = None
        self._fields = 0
        self._seen: dict[int, _Seen] = {}

    @property
    def channel(self) -> ChannelChoice:
        """Which colour is searched, in frames like the last one."""
        return self._last.channel

    @property
    def reason(self) -> str:
        """Why the last frame gave no window; empty if it gave one. It may be set."""
        return self._last.reason

    @reason.setter
    def reason(self, reason: str) -> None:
        self._last.reason = reason

    @property
    def detections(self) -> Detections | None:
        """Return what was seen in the last frame, see `Segmenter`."""
        return self._last.detections

    @property
    def in_view(self) -> Collection[str]:
        """Return the names of the lights that the last frame showed, see `Segmenter`."""
        return self._last.in_view

    @property
    def warnings(self) -> tuple[str, ...]:
        """Say what is wrong though there may be a window, see `Segmenter`."""
        return self._last.warnings

    @property
    def finding(self) -> str:
        """Return what was found out about the light, see `Segmenter`."""
        if self._pairs is not None and self._pairs.locked:
            return WITH_FIELDS
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
        kind = frame.field
        if kind is None:
            return self._of(0).sightings(frame, expected)
        segmenter = self._of(kind)
        self._fields += 1
        if isinstance(segmenter.flash, (InStep, Auto)):
            segmenter.flash.agree_with(self._leading(kind, segmenter.flash.gate_px))
        try:
            found = segmenter.sightings(frame, expected)
        except FrameError:
            self._pairs = None
            raise
        if found:
            self._seen[kind] = self._sighted(kind, found[0].window)
        self._fruitless = 0 if found or segmenter.flash.locked else self._fruitless + 1
        if self._fruitless <= PATIENCE_FIELDS or len(self.of_kind) < 2:
            self._pairs = None
            return found
        if self._pairs is None:
            self._pairs = FieldPairs(self._new_segmenter)
        if not self._pairs.usable:
            return found
        found = self._pairs.sightings(frame, expected)
        if found or self._pairs.locked:
            self._last = self._pairs.segmenter(kind)
        return found

    def _of(self, kind: int) -> Segmenter:
        """Return the segmenter of a kind, which sees the next frame."""
        if kind not in self.of_kind:
            self.of_kind[kind] = self._new_segmenter() if self.of_kind else self._last
        self._last = self.of_kind[kind]
        return self._last

    def _sighted(self, kind: int, window: Window) -> _Seen:
        """Return where a kind sees its light, and since when without a break."""
        height, width = window.lit.shape
        x = window.x0 + 0.5 * (width * window.binning[0] - 1)
        y = window.y0 + 0.5 * (height * window.binning[1] - 1)
        before = self._seen.get(kind)
        if before is None or self._fields - before.field > MOST_AGE:
            return _Seen(x, y, 0.0, 0.0, self._fields, self._fields)
        passed = self._fields - before.field
        return _Seen(
            x, y, (x - before.x) / passed, (y - before.y) / passed, self._fields, before.since)

    def _leading(self, kind: int, gate_px: float) -> Expectation | None:
        """Return where the other kind sees the light, where it has seen it for longer."""
        own, other = self._seen.get(kind), self._seen.get(1 - kind)
        if other is None or self._fields - other.field > MOST_AGE:
            return None
        if own is not None and self._fields - own.field <= MOST_AGE and own.since < other.since:
            return None
        passed = self._fields - other.field
        # It does not go straight on for longer than from one flash to the next.
        reach = gate_px * max(passed / FLASH_FIELDS, 1.0)
        return Expectation(
            other.x + passed * other.velocity_x, other.y + passed * other.velocity_y,
            (reach / GATE_SIGMA) ** 2 * np.eye(2),
        )

"""A light in step with the fields of pictures: on in all of one kind, off in all of the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.segmentation.segmenter import Segmenter, Sighting
from blob_tracker.types import Frame, Window
import numpy as np

TOP, BOTTOM = 0, 1
# Of the light in the line of the peak, what the two beside it hold on the mean: of a light of
# sigma 1 px. What is in one line of a picture alone is in one field alone, lit or not.
LEAST_BESIDE = 0.2
CONFIRMED = 3  # fields of a kind in a row that have the light, as the first may be chance


class FieldPairs:
    """
    Compare each field with the one before it, of the other kind, whose lines lie between.

    For each kind there is a segmenter that is shown all fields in the places of that kind, and of
    which the sightings in its own fields count. What is narrow in a scene at rest rises in one
    kind beside a fall, and is refused as with any motion. A light that is on in both kinds is
    none.

    Parameters
    ----------
    new_segmenter : callable
        Makes a segmenter.

    """

    def __init__(self, new_segmenter: Callable[[], Segmenter]) -> None:
        self._of_places = {kind: new_segmenter() for kind in (TOP, BOTTOM)}
        self._last: Frame | None = None
        self._in_a_row = {TOP: 0, BOTTOM: 0}  # fields of a kind that had a light

    @property
    def usable(self) -> bool:
        """Whether the flash mode compares neighbours."""
        return all(isinstance(each.flash, InStep) for each in self._of_places.values())

    @property
    def locked(self) -> bool:
        """Whether a light is followed."""
        return any(each.flash.locked for each in self._of_places.values())

    def segmenter(self, kind: int) -> Segmenter:
        """Return that of the places of a kind."""
        return self._of_places[kind]

    def sightings(self, field: Frame, expected: Expectation | None = None) -> list[Sighting]:
        """Take the next field; return the light that it shows, see `Segmenter`."""
        kind = field.field or 0
        found: list[Sighting] = []
        for places, segmenter in self._of_places.items():
            seen = segmenter.sightings(in_places_of(field, places), expected)
            if places == kind and not segmenter.finding:
                found = [each for each in seen if spans_lines(each.window)]
        self._in_a_row[kind] = self._in_a_row[kind] + 1 if found else 0
        other, self._last = self._last, field
        if other is None or self._in_a_row[kind] < CONFIRMED:
            return []
        return [
            Sighting(name, replace(window, added_noise=float(np.hypot(
                window.added_noise, scene_noise(window, field, other)))))
            for name, window in found
        ]


def in_places_of(field: Frame, kind: int) -> Frame:
    """
    Return a field as the other kind would have it, by its own pixels.

    A line of the one lies half way between two of the other. Their mean would have half the noise:
    pixels are taken from above and from below in turn, so that a slope of the scene leaves a
    pattern as fine as the pixels, in which no blob is moved.
    """
    own = field.field or 0
    if kind == own:
        return field
    image = field.image
    if kind == TOP:
        above, below = np.concatenate([image[:1], image[:-1]]), image
    else:
        above, below = image, np.concatenate([image[1:], image[-1:]])
    mixed = below.copy()
    for row in range(2):
        mixed[row::2, row::2] = above[row::2, row::2]
    down = field.binning[1] // 2
    return replace(field, image=mixed, y0=field.y0 + (kind - own) * down)


def spans_lines(window: Window) -> bool:
    """Tell whether what lit up in a window of a field is in more than one of its lines."""
    if window.unlit is None:
        return True
    rise = np.subtract(window.lit, window.unlit, dtype=np.float64)
    column = int(rise.sum(axis=0).argmax())
    lines = rise[:, max(column - 1, 0):column + 2].sum(axis=1)
    peak = int(lines.argmax())
    beside = lines[[each for each in (peak - 1, peak + 1) if 0 <= each < len(lines)]]
    return bool(beside.sum() >= 2.0 * LEAST_BESIDE * lines[peak])


def scene_noise(window: Window, field: Frame, other: Frame) -> float:
    """
    Return the standard deviation that mixing two lines adds to a pixel of either frame, DN.

    Neighbours in a line differ by d, and where they are from two lines, a and b, by (a - b)^2 more
    on the mean square; the pattern has half of a - b on either side of their mean.

    Parameters
    ----------
    window : Window
        Lit, and unlit as `in_places_of` gives it.
    field, other : Frame
        The lit one, and that of the other kind.

    """
    if window.unlit is None or window.looks > 1:
        return 0.0
    row = (window.y0 - field.y0) // field.binning[1]
    column = (window.x0 - field.x0) // field.binning[0]
    height, width = window.unlit.shape
    raw = other.image[row:row + height, column:column + width]
    mixed, alone = (
        float(np.mean(np.diff(np.asarray(each, dtype=float), axis=1) ** 2))
        for each in (window.unlit, raw)
    )
    # Of the pair, half of it for each.
    return float(np.sqrt(max(mixed - alone, 0.0) / 8.0))

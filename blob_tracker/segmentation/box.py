"""Rectangles of pixels in a frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Box(NamedTuple):
    """Columns x0 to x1 and rows y0 to y1 of a frame; x1 and y1 are one past the last."""

    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of these pixels in an image."""
        return slice(self.y0, self.y1), slice(self.x0, self.x1)

    @property
    def size(self) -> int:
        """Count of pixels."""
        return (self.x1 - self.x0) * (self.y1 - self.y0)

    def cut_through(self, column: int, row: int, shape: tuple[int, ...]) -> bool:
        """
        Tell whether the border of a (h, w) image cuts the box too near to the peak in it.

        Too near is half as far as the box reaches on the opposite side, or less: of a box of
        3 sigma it leaves 1.5 sigma, a flank on which the blob can still be placed.
        """
        x0, y0, x1, y1 = self
        left, right = column - x0, x1 - 1 - column
        top, bottom = row - y0, y1 - 1 - row
        return (
            (x0 <= 0 and 2 * left <= right)
            or (y0 <= 0 and 2 * top <= bottom)
            or (x1 >= shape[1] and 2 * right <= left)
            or (y1 >= shape[0] and 2 * bottom <= top)
        )


def whole(shape: tuple[int, int]) -> Box:
    """Return the box of all pixels of an image of this (h, w)."""
    return Box(0, 0, shape[1], shape[0])


def intersection(first: Box, second: Box) -> Box:
    """Return the pixels that two boxes share; without any where they are apart."""
    x0, y0 = max(first.x0, second.x0), max(first.y0, second.y0)
    return Box(x0, y0, max(min(first.x1, second.x1), x0), max(min(first.y1, second.y1), y0))


def box_about(column: int, row: int, half_x: int, half_y: int, shape: tuple[int, ...]) -> Box:
    """Return the box of 2 half + 1 pixels about a pixel, cut at the borders of (h, w)."""
    return Box(
        max(column - half_x, 0),
        max(row - half_y, 0),
        min(column + half_x + 1, shape[1]),
        min(row + half_y + 1, shape[0]),
    )


def component_box(mask: NDArray[np.bool_], column: int, row: int, place: Box) -> Box:
    """
    Return the bounding box of the 8-connected pixels that hang together with one pixel.

    Parameters
    ----------
    mask : (h, w) bool array
        The pixels of the blob and of others, cut out of the frame at `place`.
    column, row : int
        A pixel of the blob, in the frame.
    place : Box
        Where in the frame the mask lies.

    Returns
    -------
    Box
        In the frame.

    """
    import cv2  # no part of a start

    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    left, top, width, height, _ = (
        int(value) for value in stats[labels[row - place.y0, column - place.x0]]
    )
    x0, y0 = place.x0 + left, place.y0 + top
    return Box(x0, y0, x0 + width, y0 + height)

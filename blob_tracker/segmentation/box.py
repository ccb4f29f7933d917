"""Rectangles of pixels in a frame."""

from __future__ import annotations

from typing import NamedTuple

import cv2
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

    def touches_edge(self, shape: tuple[int, ...]) -> bool:
        """Tell whether the box reaches the border of an image of this (h, w)."""
        return self.x0 <= 0 or self.y0 <= 0 or self.x1 >= shape[1] or self.y1 >= shape[0]


def box_about(column: int, row: int, half_x: int, half_y: int, shape: tuple[int, ...]) -> Box:
    """Return the box of 2 half + 1 pixels about a pixel, cut at the borders of (h, w)."""
    return Box(
        max(column - half_x, 0),
        max(row - half_y, 0),
        min(column + half_x + 1, shape[1]),
        min(row + half_y + 1, shape[0]),
    )


def scaled(box: Box, scale: float, smallest: int, shape: tuple[int, ...]) -> Box:
    """
    Return a box `scale` times as wide and high about the same centre.

    It has an odd number of pixels, `smallest` or more, but for what (h, w) cuts off.
    """
    half_x = max(int(np.ceil(scale * (box.x1 - box.x0) / 2)), smallest // 2)
    half_y = max(int(np.ceil(scale * (box.y1 - box.y0) / 2)), smallest // 2)
    return box_about((box.x0 + box.x1 - 1) // 2, (box.y0 + box.y1 - 1) // 2, half_x, half_y, shape)


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
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    left, top, width, height, _ = (
        int(value) for value in stats[labels[row - place.y0, column - place.x0]]
    )
    x0, y0 = place.x0 + left, place.y0 + top
    return Box(x0, y0, x0 + width, y0 + height)

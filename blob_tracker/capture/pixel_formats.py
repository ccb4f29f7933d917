"""
Buffer of a camera -> luma in raw DN, one function for each pixel format.

To add a format: write its function and add its line to `PIXEL_FORMATS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import mmap

from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

PixelData = bytes | bytearray | memoryview | mmap.mmap


def grey(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the luma of GREY: one byte a pixel."""
    return _lines(data, width, height, stride).copy()


def yuyv(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the luma of YUYV: bytes Y0 U Y1 V for two pixels."""
    return _lines(data, 2 * width, height, stride)[:, ::2].copy()


def _lines(data: PixelData, line_bytes: int, height: int, stride: int) -> NDArray[np.uint8]:
    """
    Return a (height, line_bytes) view that leaves the padding at the end of each line out.

    Some drivers leave `stride` at 0 where lines have no padding, and none need pad the last line.
    """
    stride = stride or line_bytes
    if stride < line_bytes:
        raise ValueError(f'lines are {stride} bytes apart; a line alone takes {line_bytes}')
    needed = stride * (height - 1) + line_bytes
    if len(data) < needed:
        raise ValueError(f'the picture has {len(data)} bytes; it takes {needed}')
    return np.ndarray((height, line_bytes), np.uint8, data, strides=(stride, 1))


@dataclass(frozen=True)
class PixelFormat:
    """
    How a pixel format becomes luma.

    Parameters
    ----------
    luma : function
        (data, width, height, stride) -> (height, width) uint8 or uint16 array of raw DN, a copy.
        `stride` is the distance of two lines in bytes, 0 where they touch. Raises ValueError
        where `data` is too short to hold the picture.
    saturation : int
        The DN at which a pixel is clipped.

    """

    luma: Callable[[PixelData, int, int, int], Pixels]
    saturation: int


PIXEL_FORMATS = {
    'GREY': PixelFormat(grey, 255),
    'YUYV': PixelFormat(yuyv, 255),
}

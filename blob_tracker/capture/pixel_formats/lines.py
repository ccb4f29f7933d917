"""The lines of a picture in a buffer, without the padding between them."""

from __future__ import annotations

from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray


def lines(data: PixelData, line_bytes: int, height: int, stride: int) -> NDArray[np.uint8]:
    """
    Return a (height, line_bytes) view that leaves the padding at the end of each line out.

    Some drivers leave `stride` at 0 where lines have no padding, and none need pad the last line.

    Raises
    ------
    ValueError
        The lines overlap, or `data` ends before the last of them does.

    """
    stride = stride or line_bytes
    if stride < line_bytes:
        raise ValueError(f'lines are {stride} bytes apart; a line alone takes {line_bytes}')
    needed = stride * (height - 1) + line_bytes
    if len(data) < needed:
        raise ValueError(f'the picture has {len(data)} bytes; it takes {needed}')
    return np.ndarray((height, line_bytes), np.uint8, data, strides=(stride, 1))

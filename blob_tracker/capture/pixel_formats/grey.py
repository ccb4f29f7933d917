"""Grey, a sample in each byte or each 16-bit word: GREY, Y10, Y12, Y14, Y16, Y16-BE, Y012."""

from __future__ import annotations

from blob_tracker.capture.pixel_formats.lines import lines
from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray


def grey(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the samples of GREY: a byte each. The Y plane of planar YUV is laid out alike."""
    return lines(data, width, height, stride).copy()


def words(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of Y10, Y12, Y14 and Y16: the low bits of a little-endian word each."""
    return lines(data, 2 * width, height, stride).view('<u2').astype(np.uint16)


def big_endian_words(
    data: PixelData, width: int, height: int, stride: int
) -> NDArray[np.uint16]:
    """Return the samples of Y16-BE: a big-endian word each."""
    return lines(data, 2 * width, height, stride).view('>u2').astype(np.uint16)


def high_words(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of Y012: the upper 12 bits of a little-endian word each."""
    samples = words(data, width, height, stride)
    samples >>= 4
    return samples

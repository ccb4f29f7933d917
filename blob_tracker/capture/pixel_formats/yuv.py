"""
The luma of YUYV and its kin; that of planar YUV is its first plane, laid out as GREY.

The levels of YUV are of limited range (16 is black, 235 is white, ITU-R BT.601) where the driver
does not say otherwise, and so V4L2 defines its default. Many webcams go on to 255 all the same.
A pixel is taken for clipped at 235 then: a clipped pixel that passes for a good one puts the
centroid off, a good one that passes for clipped costs a little of the light.
"""

from __future__ import annotations

from blob_tracker.capture.pixel_formats.lines import lines
from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray


def luma_first(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the luma of YUYV and YVYU: bytes Y0 C Y1 C for two pixels."""
    # As words: their low bytes are copied eight times as fast as every other byte.
    return lines(data, 2 * width, height, stride).view('<u2').astype(np.uint8)


def luma_second(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the luma of UYVY and VYUY: bytes C Y0 C Y1 for two pixels."""
    return (lines(data, 2 * width, height, stride).view('<u2') >> 8).astype(np.uint8)

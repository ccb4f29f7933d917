"""
The luma of RGB: Y = 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601), clipped where a colour is.

Without the latter a red light would be clipped at a luma of 76 and no one would know. Colours of
the full range are clipped at 255, those of the limited range (16 to 235) at 235.
"""

from __future__ import annotations

from blob_tracker.capture.pixel_formats.lines import lines
from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray


def rgb24(
    data: PixelData, width: int, height: int, stride: int, saturation: int = 255
) -> NDArray[np.uint8]:
    """Return the luma of RGB3: bytes R G B."""
    return _luma(_four(data, width, height, stride), 'COLOR_RGBA2GRAY', saturation)


def bgr24(
    data: PixelData, width: int, height: int, stride: int, saturation: int = 255
) -> NDArray[np.uint8]:
    """Return the luma of BGR3: bytes B G R."""
    return _luma(_four(data, width, height, stride), 'COLOR_BGRA2GRAY', saturation)


def rgbx32(
    data: PixelData, width: int, height: int, stride: int, saturation: int = 255
) -> NDArray[np.uint8]:
    """Return the luma of AB24 and XB24: bytes R G B and one of alpha or nothing."""
    return _luma(_pixels(data, width, height, stride), 'COLOR_RGBA2GRAY', saturation)


def bgrx32(
    data: PixelData, width: int, height: int, stride: int, saturation: int = 255
) -> NDArray[np.uint8]:
    """Return the luma of BGR4, AR24 and XR24: bytes B G R and one of alpha or nothing."""
    return _luma(_pixels(data, width, height, stride), 'COLOR_BGRA2GRAY', saturation)


def xrgb32(
    data: PixelData, width: int, height: int, stride: int, saturation: int = 255
) -> NDArray[np.uint8]:
    """Return the luma of RGB4, BA24 and BX24: one byte of alpha or nothing and R G B."""
    return _luma(_pixels(data, width, height, stride, 8), 'COLOR_RGBA2GRAY', saturation)


def xbgr32(
    data: PixelData, width: int, height: int, stride: int, saturation: int = 255
) -> NDArray[np.uint8]:
    """Return the luma of RA24 and RX24: one byte of alpha or nothing and B G R."""
    return _luma(_pixels(data, width, height, stride, 8), 'COLOR_BGRA2GRAY', saturation)


def three(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the (height, width, 3) colours of three bytes a pixel, in their order."""
    return lines(data, 3 * width, height, stride).reshape(height, width, 3).copy()


def first_three(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the (height, width, 3) colours of four bytes a pixel, the last of them left out."""
    import cv2  # no part of a start

    pixels = lines(data, 4 * width, height, stride).reshape(height, width, 4)
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGBA2RGB), np.uint8)


def last_three(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """Return the (height, width, 3) colours of four bytes a pixel, the first of them left out."""
    pixels = lines(data, 4 * width, height, stride).reshape(height, width, 4)
    return np.ascontiguousarray(pixels[..., 1:])


def _pixels(
    data: PixelData, width: int, height: int, stride: int, leading: int = 0
) -> NDArray[np.uint32]:
    """Return (height, width) words, the first byte lowest, without their `leading` bits."""
    pixels = lines(data, 4 * width, height, stride).view('<u4').astype(np.uint32)
    if leading:
        pixels >>= leading
    return pixels


def _four(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint32]:
    """Return pixels of three bytes in words of four."""
    import cv2

    three = lines(data, 3 * width, height, stride).reshape(height, width, 3)
    four = cv2.cvtColor(three, cv2.COLOR_RGB2RGBA)
    return four.view(np.uint32)[..., 0]


def _luma(
    pixels: NDArray[np.uint32], conversion: str, saturation: int
) -> NDArray[np.uint8]:
    """Return the luma of (height, width) words whose low three bytes are the colours."""
    import cv2

    height, width = pixels.shape
    colours = pixels.view(np.uint8).reshape(height, width, 4)
    luma = np.asarray(cv2.cvtColor(colours, getattr(cv2, conversion)), np.uint8)
    if saturation < 255:  # bring the clipped bytes to 255, the others to 0
        _, bytes_clipped = cv2.threshold(
            pixels.view(np.uint8), saturation - 1, 255, cv2.THRESH_BINARY)
        pixels = np.asarray(bytes_clipped, np.uint8).view(np.uint32)
    # Any byte of 255 leaves its top bit: the test for a byte of zero in a word, on ~pixels.
    clipped = ~pixels
    clipped -= np.uint32(0x010101)
    clipped &= pixels
    clipped &= np.uint32(0x808080)
    if clipped.any():
        luma[clipped != 0] = saturation
    return luma

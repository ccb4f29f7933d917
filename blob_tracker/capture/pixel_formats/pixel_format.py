"""What is known about one pixel format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import mmap

from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

PixelData = bytes | bytearray | memoryview | mmap.mmap
# (data, width, height, stride) -> (height, width) array of DN
Decoder = Callable[[PixelData, int, int, int], Pixels]


@dataclass(frozen=True)
class PixelFormat:
    """
    How a buffer of a pixel format becomes a picture.

    Parameters
    ----------
    luma : function
        (data, width, height, stride) -> (height // binning, width // binning) uint8 or uint16
        array of DN, a copy. `data` is the first plane of the buffer, `stride` the distance of two
        lines in bytes, 0 where they touch. Raises ValueError where `data` does not hold the whole
        picture.
    saturation : int
        The DN at which a pixel is clipped.
    full_range_saturation : int or None
        The same where the driver says that its levels use the full range; None if that makes
        no difference.
    limited_range : PixelFormat or None
        The format where the driver says that its levels use the limited range; None if that
        makes no difference.
    binning : int
        Sensor pixels per pixel of the luma, along both axes.
    colours : function or None
        As `luma`, of the full size: the samples of a mosaic, or (height, width, n) colours. None
        where the format has no colours, or not one for each pixel.
    layout : str
        What `colours` returns, see `blob_tracker.types.Frame`.
    colour_saturation : int
        The DN at which one of the colours is clipped.
    quantisation : function or None
        From the data of a compressed picture to the (8, 8) steps of its luma, DN.
    compressed : bool
        Whether the size of a picture in bytes is not known beforehand.

    """

    luma: Decoder
    saturation: int
    full_range_saturation: int | None = None
    limited_range: PixelFormat | None = None
    binning: int = 1
    compressed: bool = False
    colours: Decoder | None = None
    layout: str = 'grey'
    colour_saturation: int = 0
    quantisation: Callable[[PixelData], NDArray[np.uint16]] | None = None

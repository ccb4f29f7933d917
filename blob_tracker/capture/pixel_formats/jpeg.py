"""The luma of motion JPEG, one picture a buffer: as sent, without a conversion of colours."""

from __future__ import annotations

import re

from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import cv2
import numpy as np
from numpy.typing import NDArray

_START, _SCAN, _END = b'\xff\xd8', b'\xff\xda', b'\xff\xd9'
# In the pixels' own data 0xff stands before 0x00, before a restart's number, or before itself.
_MARKER = re.compile(rb'\xff[^\x00\xd0-\xd7\xff]')


def jpeg(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """
    Return the Y of a baseline JPEG; `stride` means nothing here.

    Full range (JFIF): clipped at 255. The blocks of 8 x 8 pixels are quantised together, so the
    noise is not that of independent pixels: take an uncompressed format where there is one.

    Raises
    ------
    ValueError
        The picture is cut short, damaged, or of another size. Damage within the pixels that
        leaves every marker in place cannot be told.

    """
    picture = bytes(data)
    if not picture.startswith(_START):
        raise ValueError('this is no JPEG: it does not begin with its first marker')
    # The decoder would fill what is missing with grey and say nothing.
    scan = picture.find(_SCAN)
    marker = _MARKER.search(picture, scan + 2) if scan >= 0 else None
    if marker is None or marker[0] != _END:
        raise ValueError('the JPEG is cut short or damaged: its pixels do not end in its last '
                         'marker')
    try:
        luma = cv2.imdecode(np.frombuffer(picture[:marker.end()], np.uint8), cv2.IMREAD_GRAYSCALE)
    except cv2.error as error:
        raise ValueError(f'the JPEG cannot be decoded: {error.err}') from error
    if luma is None:
        raise ValueError('the JPEG cannot be decoded')
    if luma.shape != (height, width):
        raise ValueError(f'the JPEG is {luma.shape[1]}x{luma.shape[0]}, not {width}x{height}')
    return luma

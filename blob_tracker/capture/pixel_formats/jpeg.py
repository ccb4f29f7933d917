"""The luma of motion JPEG, one picture a buffer: as sent, without a conversion of colours."""

from __future__ import annotations

import re

from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import cv2
import numpy as np
from numpy.typing import NDArray

_START, _SCAN, _END = b'\xff\xd8', b'\xff\xda', b'\xff\xd9'
_FRAMES = (b'\xff\xc0', b'\xff\xc1', b'\xff\xc2')  # baseline, extended, progressive
# Among the pixels 0xff stands before 0x00, before the number of a restart, or before another.
_MARKER = re.compile(rb'\xff[^\x00\xd0-\xd7\xff]')


def jpeg(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """
    Return the Y of a JPEG; `stride` means nothing here.

    Its levels are of full range (JFIF): clipped at 255. Blocks of 8 x 8 pixels are rounded
    together, so the noise is not that of independent pixels: prefer an uncompressed format.

    Raises
    ------
    ValueError
        The picture is cut short, damaged, or of another size. Wrong bits among the pixels that
        leave every marker in its place cannot be told.

    """
    picture = bytes(data)
    end = _end(picture, width, height)
    luma = cv2.imdecode(
        np.frombuffer(picture, np.uint8, end),
        cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION,
    )
    if luma is None or luma.shape != (height, width):
        raise ValueError('the JPEG cannot be decoded')
    return np.asarray(luma, np.uint8)


def _end(picture: bytes, width: int, height: int) -> int:
    """
    Return where a JPEG ends, having gone through all of its segments.

    The decoder would fill what is missing with grey, and make room for any size, without a word.
    """
    if not picture.startswith(_START):
        raise ValueError('this is no JPEG: its first marker is missing')
    place = len(_START)
    while (marker := picture[place:place + 2]) != _END:
        if len(marker) < 2 or marker[0] != 0xff:
            raise ValueError('the JPEG is cut short or damaged: its last marker is missing')
        if marker in _FRAMES:
            size = (int.from_bytes(picture[place + 7:place + 9], 'big'),
                    int.from_bytes(picture[place + 5:place + 7], 'big'))
            if size != (width, height):
                raise ValueError(f'the JPEG is {size[0]}x{size[1]}, not {width}x{height}')
        place += 2 + int.from_bytes(picture[place + 2:place + 4], 'big')
        if marker == _SCAN:
            following = _MARKER.search(picture, place)
            place = following.start() if following else len(picture)
    return place + len(_END)

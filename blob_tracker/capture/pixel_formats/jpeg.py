"""The luma of motion JPEG, one picture a buffer: as sent, without a conversion of colours."""

from __future__ import annotations

import re

from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray

_START, _SCAN, _END = b'\xff\xd8', b'\xff\xda', b'\xff\xd9'
_TABLES = b'\xff\xdb'
_FRAMES = (b'\xff\xc0', b'\xff\xc1', b'\xff\xc2')  # baseline, extended, progressive
_SIDE = 8  # px of a block
# The coefficients in the order of the file: along the diagonals, to and fro (T.81, figure 5).
_ZIGZAG = sorted(range(_SIDE**2), key=lambda at: (
    at // _SIDE + at % _SIDE,
    at // _SIDE if (at // _SIDE + at % _SIDE) % 2 else at % _SIDE,
))
# Among the pixels 0xff stands before 0x00, before the number of a restart, or before another.
_MARKER = re.compile(rb'\xff[^\x00\xd0-\xd7\xff]')


def jpeg(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint8]:
    """
    Return the Y of a JPEG; `stride` means nothing here.

    Its levels are of full range (JFIF): clipped at 255. Blocks of 8 x 8 pixels are rounded
    together, see `luma_quantisation`, so the noise is not that of independent pixels: prefer an
    uncompressed format.

    Raises
    ------
    ValueError
        The picture is cut short, damaged, or of another size. Wrong bits among the pixels that
        leave every marker in its place cannot be told.

    """
    import cv2  # no part of a start

    picture = bytes(data)
    end, size = extent(picture)
    if size is not None and size != (width, height):
        raise ValueError(f'the JPEG is {size[0]}x{size[1]}, not {width}x{height}')
    luma = cv2.imdecode(
        np.frombuffer(picture, np.uint8, end),
        cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION,
    )
    if luma is None or luma.shape != (height, width):
        raise ValueError('the JPEG cannot be decoded')
    return np.asarray(luma, np.uint8)


def luma_quantisation(data: PixelData) -> NDArray[np.uint16]:
    """
    Return the steps in which a JPEG keeps the coefficients of its luma.

    Parameters
    ----------
    data : bytes
        The file or buffer; nothing past its first scan is looked at.

    Returns
    -------
    (8, 8) array
        Steps by row (vertical frequency) and column (horizontal frequency), DN of an orthonormal
        cosine transform (ITU-T T.81, A.3.3 and A.3.4).

    Raises
    ------
    ValueError
        There is no such table before the first scan.

    """
    picture = bytes(data)
    tables: dict[int, NDArray[np.uint16]] = {}
    luma: int | None = None
    place = len(_START)
    while (marker := picture[place:place + 2]) != _SCAN:
        length = int.from_bytes(picture[place + 2:place + 4], 'big')
        if len(marker) < 2 or marker[0] != 0xff or length < 2:
            raise ValueError('the JPEG is cut short or damaged: it has no scan')
        content = picture[place + 4:place + 2 + length]
        if marker == _TABLES:
            tables |= _quantisation(content)
        elif marker in _FRAMES and len(content) >= 9:
            luma = content[8]  # of its first component, which is Y
        place += 2 + length
    if luma not in tables:
        raise ValueError('the JPEG has no table of its luma')
    return tables[luma]


def _quantisation(content: bytes) -> dict[int, NDArray[np.uint16]]:
    """Return the tables of a segment by their number."""
    tables = {}
    place = 0
    while place < len(content):
        kind = np.dtype('>u2' if content[place] >> 4 else 'u1')
        first, last = place + 1, place + 1 + kind.itemsize * _SIDE**2
        if last > len(content):
            raise ValueError('the JPEG is damaged: a table is cut short')
        table = np.empty(_SIDE**2, np.uint16)
        table[_ZIGZAG] = np.frombuffer(content[first:last], kind)
        tables[content[place] & 15] = table.reshape(_SIDE, _SIDE)
        place = last
    return tables


def extent(picture: bytes) -> tuple[int, tuple[int, int] | None]:
    """
    Return where a JPEG ends, and its width and height, having gone through all of its segments.

    The decoder would fill what is missing with grey, and make room for any size, without a word.

    Raises
    ------
    ValueError
        The picture is cut short or damaged.

    """
    if not picture.startswith(_START):
        raise ValueError('this is not a JPEG: its first marker is missing')
    place = len(_START)
    size: tuple[int, int] | None = None
    while (marker := picture[place:place + 2]) != _END:
        if len(marker) < 2 or marker[0] != 0xff:
            raise ValueError('the JPEG is cut short or damaged: its last marker is missing')
        if marker in _FRAMES:
            size = (int.from_bytes(picture[place + 7:place + 9], 'big'),
                    int.from_bytes(picture[place + 5:place + 7], 'big'))
        place += 2 + int.from_bytes(picture[place + 2:place + 4], 'big')
        if marker == _SCAN:
            following = _MARKER.search(picture, place)
            place = following.start() if following else len(picture)
    return place + len(_END), size

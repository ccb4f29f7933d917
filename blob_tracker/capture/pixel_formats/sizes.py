"""How many bytes a picture of each pixel format takes, where lines and planes touch."""

from __future__ import annotations

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS

# Samples of a group and its bytes, by the letters that end the code of packed Bayer.
_PACKED = {'AA': (4, 5), 'CC': (2, 3), 'EE': (4, 7)}
_LINES = {  # of the first plane
    'Y10P': (4, 5), 'Y10B': (4, 5), 'Y12P': (2, 3), 'Y14P': (4, 7),
    **{name: (1, 1) for name in ('GREY', 'GRBG', 'GBRG', 'RGGB', 'BA81')},
    **{name: (1, 3) for name in ('RGB3', 'BGR3')},
    **{name: (1, 4) for name in PIXEL_FORMATS if name[:2] in ('AB', 'XB', 'AR', 'XR', 'RA', 'RX')},
    **{name: (1, 4) for name in ('BGR4', 'RGB4', 'BA24', 'BX24')},
    **{name: _PACKED[name[2:]] for name in PIXEL_FORMATS if name[2:] in _PACKED},
}
# All planes of planar YUV over that of the luma, in halves.
_HALVES = {
    **{name: 3 for name in ('NV12', 'NV21', 'YU12', 'YV12', 'NM12', 'NM21', 'YM12', 'YM21')},
    **{name: 4 for name in ('NV16', 'NV61', '422P', 'NM16', 'NM61', 'YM16', 'YM61')},
    **{name: 6 for name in ('NV24', 'NV42', 'YM24', 'YM42')},
}


def picture_bytes(pixel_format: str, width: int, height: int, stride: int = 0) -> int:
    """
    Return how many bytes a picture takes in a file of nothing but pictures.

    Parameters
    ----------
    pixel_format : str
        One of `PIXEL_FORMATS` that is not compressed.
    width, height : int
        px.
    stride : int
        Distance of two lines of the first plane, bytes; 0 where they touch.

    """
    if pixel_format in _HALVES:
        # The chromas of an odd number of lines or columns are rounded up, and no one does that.
        return (stride or width) * height * _HALVES[pixel_format] // 2
    samples, size = _LINES.get(pixel_format, (1, 2))
    return (stride or -(-width // samples) * size) * height

"""
Buffer of a camera -> luma in raw DN, one file for each family of pixel formats.

To add a format: write its function and add its line to `PIXEL_FORMATS`.
"""

from collections.abc import Callable
from functools import partial

from blob_tracker.capture.pixel_formats import bayer, grey, jpeg, packed, rgb, yuv
from blob_tracker.capture.pixel_formats.pixel_format import Decoder, PixelData, PixelFormat
from blob_tracker.types import Pixels

__all__ = ['PIXEL_FORMATS', 'PixelData', 'PixelFormat']

# The layouts of Bayer: bits of a sample, decoder of the samples, and the four-character codes in
# the orders GRBG, GBRG (green in column 0 of row 0), RGGB, BGGR (green in column 1).
_BAYER = (
    (8, grey.grey, ('GRBG', 'GBRG', 'RGGB', 'BA81')),
    (10, grey.words, ('BA10', 'GB10', 'RG10', 'BG10')),
    (10, packed.mipi10, ('pgAA', 'pGAA', 'pRAA', 'pBAA')),
    (12, grey.words, ('BA12', 'GB12', 'RG12', 'BG12')),
    (12, packed.mipi12, ('pgCC', 'pGCC', 'pRCC', 'pBCC')),
    (14, grey.words, ('GR14', 'GB14', 'RG14', 'BG14')),
    (14, packed.mipi14, ('pgEE', 'pGEE', 'pREE', 'pBEE')),
    (16, grey.words, ('GR16', 'GB16', 'RG16', 'BYR2')),
)


def _rgb(luma: Callable[..., Pixels], colours: Decoder, layout: str) -> PixelFormat:
    return PixelFormat(
        luma, 255, colours=colours, layout=layout, colour_saturation=255,
        limited_range=PixelFormat(
            partial(luma, saturation=235), 235, colours=colours, layout=layout,
            colour_saturation=235))


_JPEG = PixelFormat(jpeg.jpeg, 255, compressed=True, quantisation=jpeg.luma_quantisation)


# The four-character code, as `v4l2-ctl --list-formats` prints it -> the format.
PIXEL_FORMATS = {
    'GREY': PixelFormat(grey.grey, 255),
    'Y10': PixelFormat(grey.words, 1023),
    'Y10P': PixelFormat(packed.mipi10, 1023),
    'Y10B': PixelFormat(packed.bits10, 1023),
    'Y12': PixelFormat(grey.words, 4095),
    'Y12P': PixelFormat(packed.mipi12, 4095),
    'Y012': PixelFormat(grey.high_words, 4095),
    'Y14': PixelFormat(grey.words, 16383),
    'Y14P': PixelFormat(packed.mipi14, 16383),
    'Y16': PixelFormat(grey.words, 65535),
    'Y16-BE': PixelFormat(grey.big_endian_words, 65535),
    'YUYV': PixelFormat(yuv.luma_first, 235, 255),
    'YVYU': PixelFormat(yuv.luma_first, 235, 255),
    'UYVY': PixelFormat(yuv.luma_second, 235, 255),
    'VYUY': PixelFormat(yuv.luma_second, 235, 255),
    **{
        name: PixelFormat(grey.grey, 235, 255)  # planar: the luma comes first
        for name in (
            'NV12', 'NV21', 'NV16', 'NV61', 'NV24', 'NV42', 'YU12', 'YV12', '422P',
            # with a buffer for each plane
            'NM12', 'NM21', 'NM16', 'NM61', 'YM12', 'YM21', 'YM16', 'YM61', 'YM24', 'YM42',
        )
    },
    'RGB3': _rgb(rgb.rgb24, rgb.three, 'rgb'),
    'BGR3': _rgb(rgb.bgr24, rgb.three, 'bgr'),
    **{name: _rgb(rgb.rgbx32, rgb.first_three, 'rgb') for name in ('AB24', 'XB24')},
    **{name: _rgb(rgb.bgrx32, rgb.first_three, 'bgr') for name in ('BGR4', 'AR24', 'XR24')},
    **{name: _rgb(rgb.xrgb32, rgb.last_three, 'rgb') for name in ('RGB4', 'BA24', 'BX24')},
    **{name: _rgb(rgb.xbgr32, rgb.last_three, 'bgr') for name in ('RA24', 'RX24')},
    **{
        name: PixelFormat(
            bayer.green(samples, first, bits), bayer.saturation(bits), binning=2,
            colours=samples, layout=layout, colour_saturation=(1 << bits) - 1)
        for bits, samples, names in _BAYER
        for first, layout, name in zip((0, 0, 1, 1), ('grbg', 'gbrg', 'rggb', 'bggr'), names)
    },
    'MJPG': _JPEG,
    'JPEG': _JPEG,
}

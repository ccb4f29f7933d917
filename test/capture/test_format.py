"""What a driver makes of a format that is asked for, where vivid in test/vm cannot show it."""

from __future__ import annotations

import errno
from typing import Any

from blob_tracker.capture import CaptureError, videodev2
from blob_tracker.capture.format import set_format, StreamFormat
import numpy as np
import pytest

BYTES = {'YUYV': 2, 'UYVY': 2, 'RGB3': 3}  # of a pixel, where it is not one


class Webcam:
    """
    A camera with a few sizes of each format, left at one of them by the program before.

    Parameters
    ----------
    sizes : dict
        pixel format -> its sizes, the first of which is given for any that it lacks.
    current : (str, int, int)
        Pixel format, width and height as the device was left.
    quantization : int
        Range of the levels that it gives.
    field : str
        What it gives for any that it lacks.
    fields : tuple of str
        What it has.

    """

    def __init__(
        self, sizes: dict[str, list[tuple[int, int]]], current: tuple[str, int, int],
        quantization: int = videodev2.QUANTIZATION_DEFAULT, field: str = 'none',
        fields: tuple[str, ...] = (),
    ) -> None:
        self.sizes = sizes
        self.current = current
        self.quantization = quantization
        self.field, self.fields, self.left_at = field, fields, 'none'

    def __call__(self, number: int, argument: Any) -> None:
        if number == videodev2.ENUM_FMT:
            if argument.index >= len(self.sizes):
                raise OSError(errno.EINVAL, 'Invalid argument')
            argument.pixelformat = videodev2.fourcc(list(self.sizes)[argument.index])
        elif number == videodev2.ENUM_FRAMESIZES:
            raise OSError(errno.ENOTTY, 'Inappropriate ioctl for device')
        else:
            pix = argument.pix
            if number == videodev2.S_FMT:
                name = videodev2.fourcc_name(pix.pixelformat)
                size = (pix.width, pix.height)
                known = self.sizes[name]
                self.current = (name, *(size if size in known else known[0]))
            name, pix.width, pix.height = self.current
            pix.pixelformat = videodev2.fourcc(name)
            pix.bytesperline = BYTES.get(name, 1) * pix.width
            pix.sizeimage = pix.bytesperline * pix.height
            pix.quantization = self.quantization
            if number == videodev2.G_FMT:
                pix.field = videodev2.FIELDS.index(self.left_at)
            else:
                asked = videodev2.FIELDS[pix.field]
                if self.field == 'refused' and asked == 'none':
                    raise OSError(errno.EINVAL, 'Invalid argument')
                given = asked if asked in self.fields else self.field
                pix.field = videodev2.FIELDS.index(given.replace('refused', 'interlaced'))

    def negotiated(
        self, width: int = 0, height: int = 0, pixel_format: str = '', field_order: str = '',
        standard_lines: int = 0,
    ) -> StreamFormat:
        return set_format(
            self, '/dev/video0', videodev2.BUF_TYPE_VIDEO_CAPTURE, width, height, pixel_format,
            field_order=field_order, standard_lines=standard_lines)


SIZES = {'MJPG': [(640, 480), (1920, 1080)], 'YUYV': [(640, 480), (320, 240)]}


def test_a_size_that_nobody_asked_for_is_not_insisted_on():
    found = Webcam(SIZES, ('MJPG', 1920, 1080)).negotiated()
    assert (found.pixel_format, found.width, found.height) == ('YUYV', 640, 480)
    assert found.stride == 1280


@pytest.mark.parametrize('size', [(1920, 1080), (1920, 0), (0, 1080)])
def test_a_size_that_was_asked_for_is_insisted_on(size):
    with pytest.raises(CaptureError) as error:
        Webcam(SIZES, ('MJPG', 1920, 1080)).negotiated(size[0], size[1], 'YUYV')
    assert str(error.value) == ('/dev/video0: 1920x1080 is not offered; the driver gives 640x480 '
                                'instead')


@pytest.mark.parametrize(('left_at', 'wanted', 'taken'), [
    ('UYVY', '', 'UYVY'),  # readable: as it is
    ('MJPG', '', 'YUYV'),  # compressed: the first that is not
    ('H264', '', 'YUYV'),  # unreadable
    ('UYVY', 'MJPG', 'MJPG'),
])
def test_the_pixel_format_stays_where_it_can_be_read(left_at, wanted, taken):
    sizes = {name: [(640, 480)] for name in ('MJPG', 'H264', 'YUYV', 'UYVY')}
    assert Webcam(sizes, (left_at, 640, 480)).negotiated(pixel_format=wanted).pixel_format == taken


@pytest.mark.parametrize(('name', 'quantization', 'saturation'), [
    ('RGB3', videodev2.QUANTIZATION_DEFAULT, 255),
    ('RGB3', videodev2.QUANTIZATION_FULL_RANGE, 255),
    ('RGB3', videodev2.QUANTIZATION_LIM_RANGE, 235),
    ('YUYV', videodev2.QUANTIZATION_DEFAULT, 235),
    ('YUYV', videodev2.QUANTIZATION_FULL_RANGE, 255),
    ('YUYV', videodev2.QUANTIZATION_LIM_RANGE, 235),
])
def test_the_range_of_the_levels_tells_where_they_are_clipped(name, quantization, saturation):
    found = Webcam({name: [(4, 2)]}, (name, 4, 2), quantization).negotiated()
    assert found.saturation == saturation
    grey = np.full(found.stride * 2, 100, np.uint8)
    grey[0] = saturation  # red, or the luma, of the first pixel
    assert (found.picture(grey.tobytes()) >= saturation).sum() == 1


@pytest.mark.parametrize(('channel', 'layout', 'binning'), [
    ('luma', 'grey', 1), ('auto', 'rgb', 1), ('red', 'rgb', 1),
])
def test_colours_are_read_where_they_are_asked_for(channel, layout, binning):
    camera = Webcam({'RGB3': [(4, 2)]}, ('RGB3', 4, 2))
    found = set_format(
        camera, '/dev/video0', videodev2.BUF_TYPE_VIDEO_CAPTURE, 0, 0, '', channel)
    assert (found.layout, found.binning) == (layout, binning)
    picture = found.picture(bytes(range(24)))
    assert picture.shape == ((2, 4) if layout == 'grey' else (2, 4, 3))


def test_a_colour_of_a_format_without_is_refused():
    # Not luma in its place: the light might be dark in it.
    camera = Webcam({'YUYV': [(4, 2)]}, ('YUYV', 4, 2))
    with pytest.raises(CaptureError, match='channel is red and YUYV has no colour for each pixel'):
        set_format(camera, '/dev/video0', videodev2.BUF_TYPE_VIDEO_CAPTURE, 0, 0, '', 'red')
    found = set_format(
        camera, '/dev/video0', videodev2.BUF_TYPE_VIDEO_CAPTURE, 0, 0, '', 'auto')
    assert found.layout == 'grey'


GRABBER = {'UYVY': [(720, 480)]}, ('UYVY', 720, 480)


@pytest.mark.parametrize(('field', 'fields', 'asked', 'words'), [
    ('none', (), '', 'none, whole pictures'),
    ('any', (), '', 'none, whole pictures'),  # of a driver that knows nothing of fields
    ('interlaced', (), '', 'bottom before top, line by line'),
    ('interlaced', (), 'interlaced_tb', 'top before bottom, line by line'),  # who asks knows
    ('refused', (), '', 'bottom before top, line by line'),  # EINVAL for whole pictures
    ('interlaced', ('top', 'alternate'), 'top', 'top alone'),
    ('interlaced', ('top', 'alternate'), 'alternate', 'one after the other'),
    ('seq_bt', (), '', 'bottom before top, one above the other'),
])
def test_fields_are_taken_where_there_are_no_whole_pictures(field, fields, asked, words):
    found = Webcam(*GRABBER, field=field, fields=fields).negotiated(field_order=asked)
    assert str(found.fields) == words


def test_the_standard_tells_which_field_is_first():
    found = Webcam(*GRABBER, field='interlaced').negotiated(standard_lines=625)
    assert str(found.fields) == 'top before bottom, line by line'


@pytest.mark.parametrize(('left_at', 'asked', 'lines'), [
    ('interlaced', 'top', 240), ('top', '', 960), ('top', 'alternate', 480),
    ('interlaced', '', 480),
])
def test_a_field_has_half_of_the_lines_that_the_picture_had(left_at, asked, lines):
    # Where nobody asks for a height: drivers count the lines of a buffer.
    camera = Webcam(
        {'UYVY': [(720, 480), (720, 240), (720, 960)]}, ('UYVY', 720, 480), field='interlaced',
        fields=('top', 'alternate'))
    camera.left_at = left_at
    assert camera.negotiated(field_order=asked).height == lines


def test_fields_that_cannot_be_had_are_told():
    with pytest.raises(CaptureError, match='fields is top and the driver gives interlaced at'):
        Webcam(*GRABBER, field='interlaced').negotiated(field_order='top')
    with pytest.raises(CaptureError, match='fields is top and the driver gives whole pictures'):
        Webcam(*GRABBER).negotiated(field_order='top')
    with pytest.raises(CaptureError, match='the lines of a mosaic are none; set pixel_format'):
        Webcam({'RGGB': [(720, 480)]}, ('RGGB', 720, 480), field='interlaced').negotiated()
    with pytest.raises(CaptureError, match='pictures of 2 lines have no fields'):
        Webcam({'UYVY': [(4, 2)]}, ('UYVY', 4, 2), field='interlaced').negotiated()


@pytest.mark.parametrize(('names', 'words'), [
    (['H264', 'HEVC'], '; H264, HEVC: video that is compressed over several pictures;'),
    (['PC1B', 'PC1M'], '; PC1B, PC1M: raw that the camera interface of a Raspberry Pi 5 has'),
    (['ip3y'], "; ip3y: packed raw of Intel's IPU3"),
])
def test_formats_that_are_not_decoded_are_known(names, words):
    camera = Webcam({name: [(640, 480)] for name in names}, (names[0], 640, 480))
    with pytest.raises(CaptureError) as error:
        camera.negotiated()
    assert words in str(error.value)
    with pytest.raises(CaptureError, match=f"'{names[0]}' cannot be decoded"):
        camera.negotiated(pixel_format=names[0])

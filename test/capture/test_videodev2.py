"""The kernel's layouts and numbers, against those that <linux/videodev2.h> gives on x86-64."""

import ctypes

from blob_tracker.capture import videodev2
import pytest


@pytest.mark.parametrize(('struct', 'size'), [
    (videodev2.Capability, 104),
    (videodev2.Input, 80),
    (videodev2.BtTimings, 124),
    (videodev2.DvTimings, 132),
    (videodev2.FmtDesc, 64),
    (videodev2.FrameSizeEnum, 44),
    (videodev2.PixFormat, 48),
    (videodev2.Format, 208),
    (videodev2.PlanePixFormat, 20),
    (videodev2.PixFormatMplane, 192),
    (videodev2.Rect, 16),
    (videodev2.CropCap, 44),
    (videodev2.Selection, 64),
    (videodev2.StreamParm, 204),
    (videodev2.RequestBuffers, 20),
    (videodev2.Timecode, 16),
    (videodev2.Buffer, 88),
    (videodev2.QueryExtCtrl, 232),
    (videodev2.QueryMenu, 44),
    (videodev2.ExtControl, 20),
    (videodev2.ExtControls, 32),
    (videodev2.Event, 136),
    (videodev2.EventSubscription, 32),
])
def test_struct_size(struct, size):
    assert ctypes.sizeof(struct) == size


@pytest.mark.parametrize(('struct', 'field', 'offset'), [
    (videodev2.Input, 'status', 56),
    (videodev2.Input, 'capabilities', 60),
    (videodev2.BtTimings, 'pixelclock', 16),
    (videodev2.BtTimings, 'flags', 64),
    (videodev2.DvTimings, 'bt', 4),
    (videodev2.FrameSizeEnum, 'min_width', 12),
    (videodev2.Format, 'pix', 8),
    (videodev2.Format, 'pix_mp', 8),
    (videodev2.PixFormatMplane, 'plane_fmt', 20),
    (videodev2.PixFormatMplane, 'num_planes', 180),
    (videodev2.PixFormatMplane, 'quantization', 183),
    (videodev2.CropCap, 'pixelaspect', 36),
    (videodev2.Selection, 'r', 12),
    (videodev2.Plane, 'm', 8),
    (videodev2.Plane, 'data_offset', 16),
    (videodev2.StreamParm, 'timeperframe', 12),
    (videodev2.Buffer, 'timestamp', 24),
    (videodev2.Buffer, 'timecode', 40),
    (videodev2.Buffer, 'sequence', 56),
    (videodev2.Buffer, 'm', 64),
    (videodev2.Buffer, 'length', 72),
    (videodev2.QueryExtCtrl, 'minimum', 40),
    (videodev2.QueryExtCtrl, 'flags', 72),
    (videodev2.QueryExtCtrl, 'elem_size', 76),
    (videodev2.QueryMenu, 'item', 8),
    (videodev2.ExtControl, 'value', 12),
    (videodev2.ExtControls, 'controls', 24),
    (videodev2.Event, 'timestamp', 80),
    (videodev2.Event, 'id', 96),
])
def test_field_offset(struct, field, offset):
    assert getattr(struct, field).offset == offset


@pytest.mark.parametrize(('name', 'number'), [
    ('QUERYCAP', 0x80685600),
    ('ENUM_FMT', 0xc0405602),
    ('G_FMT', 0xc0d05604),
    ('S_FMT', 0xc0d05605),
    ('REQBUFS', 0xc0145608),
    ('QUERYBUF', 0xc0585609),
    ('QBUF', 0xc058560f),
    ('DQBUF', 0xc0585611),
    ('STREAMON', 0x40045612),
    ('STREAMOFF', 0x40045613),
    ('G_PARM', 0xc0cc5615),
    ('S_PARM', 0xc0cc5616),
    ('G_STD', 0x80085617),
    ('S_STD', 0x40085618),
    ('ENUMINPUT', 0xc050561a),
    ('QUERYMENU', 0xc02c5625),
    ('G_INPUT', 0x80045626),
    ('CROPCAP', 0xc02c563a),
    ('QUERYSTD', 0x8008563f),
    ('G_EXT_CTRLS', 0xc0205647),
    ('S_EXT_CTRLS', 0xc0205648),
    ('ENUM_FRAMESIZES', 0xc02c564a),
    ('S_DV_TIMINGS', 0xc0845657),
    ('G_SELECTION', 0xc040565e),
    ('S_SELECTION', 0xc040565f),
    ('DQEVENT', 0x80885659),
    ('SUBSCRIBE_EVENT', 0x4020565a),
    ('QUERY_DV_TIMINGS', 0x80845663),
    ('QUERY_EXT_CTRL', 0xc0e85667),
])
def test_ioctl_number(name, number):
    assert getattr(videodev2, name) == number


@pytest.mark.parametrize(('name', 'number'), [
    ('GREY', 0x59455247),
    ('YUYV', 0x56595559),
    ('Y16', 0x20363159),
])
def test_fourcc_both_ways(name, number):
    assert videodev2.fourcc(name) == number
    assert videodev2.fourcc_name(number) == name


def test_big_endian_format_is_told_from_its_twin():
    assert videodev2.fourcc_name(0xa0363159) == 'Y16-BE'
    assert videodev2.fourcc('Y16-BE') == 0xa0363159

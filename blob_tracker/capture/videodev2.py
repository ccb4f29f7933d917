"""
The kernel's video capture interface: the structs, numbers and flags that streaming needs.

Layouts are those of 64-bit Linux. Names, values and meanings follow the kernel's "Media
subsystem" documentation, Part I (Video for Linux API). An ioctl's number carries the size of its
struct, so a wrong layout gives a wrong number.
"""

from __future__ import annotations

import ctypes
from ctypes import (
    c_char, c_int32, c_int64, c_long, c_uint16, c_uint32, c_uint64, c_uint8, c_ulong, c_void_p)
import fcntl
from typing import Any

# v4l2_capability.capabilities
CAP_VIDEO_CAPTURE = 0x00000001
CAP_VIDEO_OUTPUT = 0x00000002
CAP_VIDEO_CAPTURE_MPLANE = 0x00001000
CAP_VIDEO_OUTPUT_MPLANE = 0x00002000
CAP_VIDEO_M2M_MPLANE = 0x00004000
CAP_VIDEO_M2M = 0x00008000
CAP_META_CAPTURE = 0x00800000
CAP_STREAMING = 0x04000000
CAP_DEVICE_CAPS = 0x80000000

BUF_TYPE_VIDEO_CAPTURE = 1
BUF_TYPE_VIDEO_CAPTURE_MPLANE = 9
BUF_TYPE_META_CAPTURE = 13
MEMORY_MMAP = 1
# v4l2_field by its number
FIELDS = (
    'any', 'none', 'top', 'bottom', 'interlaced', 'seq_tb', 'seq_bt', 'alternate',
    'interlaced_tb', 'interlaced_bt',
)
FRMSIZE_TYPE_DISCRETE = 1
FMT_FLAG_COMPRESSED = 0x0001
COLORSPACE_JPEG = 7
QUANTIZATION_DEFAULT = 0
QUANTIZATION_FULL_RANGE = 1
QUANTIZATION_LIM_RANGE = 2
SEL_TGT_CROP = 0x0000
SEL_TGT_CROP_DEFAULT = 0x0001
SEL_TGT_COMPOSE = 0x0100
MAX_PLANES = 8

# v4l2_captureparm.capability
CAP_TIMEPERFRAME = 0x1000

# v4l2_buffer.flags
BUF_FLAG_ERROR = 0x00000040
BUF_FLAG_TIMESTAMP_MASK = 0x0000e000
BUF_FLAG_TIMESTAMP_MONOTONIC = 0x00002000
BUF_FLAG_TSTAMP_SRC_MASK = 0x00070000
BUF_FLAG_TSTAMP_SRC_SOE = 0x00010000

# v4l2_input.capabilities and .status
IN_CAP_DV_TIMINGS = 0x00000002
IN_CAP_STD = 0x00000004
IN_ST_NO_POWER = 0x00000001
IN_ST_NO_SIGNAL = 0x00000002
IN_ST_NO_H_LOCK = 0x00000100
IN_ST_NO_SYNC = 0x00010000

# v4l2_std_id: the video standards of 525 lines and 60 fields a second, and of 625 and 50
STD_525_60 = 0x0000f900
STD_625_50 = 0x00ff06ff

# v4l2_query_ext_ctrl.id: the next control that is neither an array nor of a compound type
CTRL_FLAG_NEXT_CTRL = 0x80000000

# v4l2_query_ext_ctrl.type
CTRL_TYPE_INTEGER = 1
CTRL_TYPE_BOOLEAN = 2
CTRL_TYPE_MENU = 3
CTRL_TYPE_BUTTON = 4
CTRL_TYPE_INTEGER64 = 5
CTRL_TYPE_STRING = 7
CTRL_TYPE_BITMASK = 8
CTRL_TYPE_INTEGER_MENU = 9

# v4l2_query_ext_ctrl.flags
CTRL_FLAG_DISABLED = 0x0001
CTRL_FLAG_GRABBED = 0x0002
CTRL_FLAG_READ_ONLY = 0x0004
CTRL_FLAG_INACTIVE = 0x0010
CTRL_FLAG_WRITE_ONLY = 0x0040
CTRL_FLAG_VOLATILE = 0x0080

# v4l2_event.type: a control has changed
EVENT_CTRL = 3

# Controls by number, as their names differ between versions of the kernel
CID_EXPOSURE = 0x00980911
CID_AUTOGAIN = 0x00980912
CID_GAIN = 0x00980913
CID_EXPOSURE_AUTO = 0x009a0901
CID_EXPOSURE_ABSOLUTE = 0x009a0902
CID_VBLANK = 0x009e0901
CID_HBLANK = 0x009e0902
CID_ANALOGUE_GAIN = 0x009e0903
CID_PIXEL_RATE = 0x009f0902


class Fract(ctypes.Structure):
    """v4l2_fract."""

    _fields_ = [('numerator', c_uint32), ('denominator', c_uint32)]


class Capability(ctypes.Structure):
    """v4l2_capability."""

    _fields_ = [
        ('driver', c_char * 16),
        ('card', c_char * 32),
        ('bus_info', c_char * 32),
        ('version', c_uint32),
        ('capabilities', c_uint32),
        ('device_caps', c_uint32),
        ('reserved', c_uint32 * 3),
    ]


class Input(ctypes.Structure):
    """v4l2_input."""

    _fields_ = [
        ('index', c_uint32),
        ('name', c_char * 32),
        ('type', c_uint32),
        ('audioset', c_uint32),
        ('tuner', c_uint32),
        ('std', c_uint64),
        ('status', c_uint32),
        ('capabilities', c_uint32),
        ('reserved', c_uint32 * 3),
    ]


class BtTimings(ctypes.Structure):
    """v4l2_bt_timings: blanking in pixels and lines, the pixel clock in Hz."""

    _pack_ = 1
    _fields_ = [
        ('width', c_uint32),
        ('height', c_uint32),
        ('interlaced', c_uint32),
        ('polarities', c_uint32),
        ('pixelclock', c_uint64),
        ('hfrontporch', c_uint32),
        ('hsync', c_uint32),
        ('hbackporch', c_uint32),
        ('vfrontporch', c_uint32),
        ('vsync', c_uint32),
        ('vbackporch', c_uint32),
        ('il_vfrontporch', c_uint32),
        ('il_vsync', c_uint32),
        ('il_vbackporch', c_uint32),
        ('standards', c_uint32),
        ('flags', c_uint32),
        ('picture_aspect', Fract),
        ('cea861_vic', c_uint8),
        ('hdmi_vic', c_uint8),
        ('reserved', c_uint8 * 46),
    ]


class DvTimings(ctypes.Structure):
    """v4l2_dv_timings."""

    _pack_ = 1
    _fields_ = [('type', c_uint32), ('bt', BtTimings), ('_union', c_uint8 * 4)]


class FmtDesc(ctypes.Structure):
    """v4l2_fmtdesc."""

    _fields_ = [
        ('index', c_uint32),
        ('type', c_uint32),
        ('flags', c_uint32),
        ('description', c_char * 32),
        ('pixelformat', c_uint32),
        ('mbus_code', c_uint32),
        ('reserved', c_uint32 * 3),
    ]


class FrameSizeEnum(ctypes.Structure):
    """v4l2_frmsizeenum; a discrete size is (min_width, max_width) of its union."""

    _fields_ = [
        ('index', c_uint32),
        ('pixel_format', c_uint32),
        ('type', c_uint32),
        ('min_width', c_uint32),
        ('max_width', c_uint32),
        ('step_width', c_uint32),
        ('min_height', c_uint32),
        ('max_height', c_uint32),
        ('step_height', c_uint32),
        ('reserved', c_uint32 * 2),
    ]


class PixFormat(ctypes.Structure):
    """v4l2_pix_format."""

    _fields_ = [
        ('width', c_uint32),
        ('height', c_uint32),
        ('pixelformat', c_uint32),
        ('field', c_uint32),
        ('bytesperline', c_uint32),
        ('sizeimage', c_uint32),
        ('colorspace', c_uint32),
        ('priv', c_uint32),
        ('flags', c_uint32),
        ('ycbcr_enc', c_uint32),
        ('quantization', c_uint32),
        ('xfer_func', c_uint32),
    ]


class PlanePixFormat(ctypes.Structure):
    """v4l2_plane_pix_format."""

    _pack_ = 1
    _fields_ = [
        ('sizeimage', c_uint32),
        ('bytesperline', c_uint32),
        ('reserved', c_uint16 * 6),
    ]


class PixFormatMplane(ctypes.Structure):
    """v4l2_pix_format_mplane."""

    _pack_ = 1
    _fields_ = [
        ('width', c_uint32),
        ('height', c_uint32),
        ('pixelformat', c_uint32),
        ('field', c_uint32),
        ('colorspace', c_uint32),
        ('plane_fmt', PlanePixFormat * MAX_PLANES),
        ('num_planes', c_uint8),
        ('flags', c_uint8),
        ('ycbcr_enc', c_uint8),
        ('quantization', c_uint8),
        ('xfer_func', c_uint8),
        ('reserved', c_uint8 * 7),
    ]


class _AnyFormat(ctypes.Union):
    """The 200-byte union of v4l2_format."""

    _fields_ = [('pix', PixFormat), ('pix_mp', PixFormatMplane), ('_raw', c_uint8 * 200)]


class Format(ctypes.Structure):
    """v4l2_format; its union is aligned to 8 bytes."""

    _anonymous_ = ('_fmt',)
    _fields_ = [('type', c_uint32), ('_alignment', c_uint32), ('_fmt', _AnyFormat)]


class Rect(ctypes.Structure):
    """v4l2_rect."""

    _fields_ = [('left', c_int32), ('top', c_int32), ('width', c_uint32), ('height', c_uint32)]


class CropCap(ctypes.Structure):
    """v4l2_cropcap; `pixelaspect` is the height of a pixel by its width, unscaled."""

    _fields_ = [('type', c_uint32), ('bounds', Rect), ('defrect', Rect), ('pixelaspect', Fract)]


class Selection(ctypes.Structure):
    """v4l2_selection."""

    _fields_ = [
        ('type', c_uint32),
        ('target', c_uint32),
        ('flags', c_uint32),
        ('r', Rect),
        ('reserved', c_uint32 * 9),
    ]


class StreamParm(ctypes.Structure):
    """v4l2_streamparm with the capture member of its 200-byte union."""

    _fields_ = [
        ('type', c_uint32),
        ('capability', c_uint32),
        ('capturemode', c_uint32),
        ('timeperframe', Fract),
        ('extendedmode', c_uint32),
        ('readbuffers', c_uint32),
        ('_union', c_uint8 * (200 - 24)),
    ]


class RequestBuffers(ctypes.Structure):
    """v4l2_requestbuffers."""

    _fields_ = [
        ('count', c_uint32),
        ('type', c_uint32),
        ('memory', c_uint32),
        ('capabilities', c_uint32),
        ('flags', c_uint8),
        ('reserved', c_uint8 * 3),
    ]


class Timeval(ctypes.Structure):
    """timeval."""

    _fields_ = [('tv_sec', c_long), ('tv_usec', c_long)]


class Timecode(ctypes.Structure):
    """v4l2_timecode."""

    _fields_ = [
        ('type', c_uint32),
        ('flags', c_uint32),
        ('frames', c_uint8),
        ('seconds', c_uint8),
        ('minutes', c_uint8),
        ('hours', c_uint8),
        ('userbits', c_uint8 * 4),
    ]


class _PlanePlace(ctypes.Union):
    """Where a plane's memory is: the union `m` of v4l2_plane."""

    _fields_ = [('mem_offset', c_uint32), ('userptr', c_ulong), ('fd', c_int32)]


class Plane(ctypes.Structure):
    """v4l2_plane; `bytesused` counts the bytes before `data_offset` too."""

    _fields_ = [
        ('bytesused', c_uint32),
        ('length', c_uint32),
        ('m', _PlanePlace),
        ('data_offset', c_uint32),
        ('reserved', c_uint32 * 11),
    ]


class _Place(ctypes.Union):
    """Where a buffer's memory is: the union `m` of v4l2_buffer."""

    _fields_ = [
        ('offset', c_uint32),
        ('userptr', c_ulong),
        ('planes', ctypes.POINTER(Plane)),
        ('fd', c_int32),
    ]


class Buffer(ctypes.Structure):
    """v4l2_buffer."""

    _fields_ = [
        ('index', c_uint32),
        ('type', c_uint32),
        ('bytesused', c_uint32),
        ('flags', c_uint32),
        ('field', c_uint32),
        ('timestamp', Timeval),
        ('timecode', Timecode),
        ('sequence', c_uint32),
        ('memory', c_uint32),
        ('m', _Place),
        ('length', c_uint32),
        ('reserved2', c_uint32),
        ('request_fd', c_int32),
    ]


class QueryExtCtrl(ctypes.Structure):
    """v4l2_query_ext_ctrl."""

    _fields_ = [
        ('id', c_uint32),
        ('type', c_uint32),
        ('name', c_char * 32),
        ('minimum', c_int64),
        ('maximum', c_int64),
        ('step', c_uint64),
        ('default_value', c_int64),
        ('flags', c_uint32),
        ('elem_size', c_uint32),
        ('elems', c_uint32),
        ('nr_of_dims', c_uint32),
        ('dims', c_uint32 * 4),
        ('reserved', c_uint32 * 32),
    ]


class _MenuItem(ctypes.Union):
    """The item of a menu or of an integer menu: the union of v4l2_querymenu."""

    _pack_ = 1
    _fields_ = [('name', c_char * 32), ('value', c_int64)]


class QueryMenu(ctypes.Structure):
    """v4l2_querymenu."""

    _pack_ = 1
    _fields_ = [
        ('id', c_uint32),
        ('index', c_uint32),
        ('item', _MenuItem),
        ('reserved', c_uint32),
    ]


class _ControlValue(ctypes.Union):
    """A control's value: the union of v4l2_ext_control."""

    _pack_ = 1
    _fields_ = [('value', c_int32), ('value64', c_int64), ('string', c_void_p)]


class ExtControl(ctypes.Structure):
    """v4l2_ext_control."""

    _pack_ = 1
    _fields_ = [
        ('id', c_uint32),
        ('size', c_uint32),
        ('reserved2', c_uint32),
        ('value', _ControlValue),
    ]


class ExtControls(ctypes.Structure):
    """v4l2_ext_controls."""

    _fields_ = [
        ('which', c_uint32),
        ('count', c_uint32),
        ('error_idx', c_uint32),
        ('request_fd', c_int32),
        ('reserved', c_uint32),
        ('controls', ctypes.POINTER(ExtControl)),
    ]


class Timespec(ctypes.Structure):
    """timespec."""

    _fields_ = [('tv_sec', c_long), ('tv_nsec', c_long)]


class Event(ctypes.Structure):
    """v4l2_event."""

    _fields_ = [
        ('type', c_uint32),
        ('_alignment', c_uint32),
        ('_union', c_uint8 * 64),
        ('pending', c_uint32),
        ('sequence', c_uint32),
        ('timestamp', Timespec),
        ('id', c_uint32),
        ('reserved', c_uint32 * 8),
    ]


class EventSubscription(ctypes.Structure):
    """v4l2_event_subscription."""

    _fields_ = [
        ('type', c_uint32),
        ('id', c_uint32),
        ('flags', c_uint32),
        ('reserved', c_uint32 * 5),
    ]


_WRITE, _READ = 1, 2  # as seen from the program


def _ioc(direction: int, number: int, argument: type[Any]) -> int:
    """Return the ioctl number of type 'V': direction 2 bits, size 14, type 8, number 8."""
    return direction << 30 | ctypes.sizeof(argument) << 16 | ord('V') << 8 | number


QUERYCAP = _ioc(_READ, 0, Capability)
ENUM_FMT = _ioc(_READ | _WRITE, 2, FmtDesc)
G_FMT = _ioc(_READ | _WRITE, 4, Format)
S_FMT = _ioc(_READ | _WRITE, 5, Format)
REQBUFS = _ioc(_READ | _WRITE, 8, RequestBuffers)
QUERYBUF = _ioc(_READ | _WRITE, 9, Buffer)
QBUF = _ioc(_READ | _WRITE, 15, Buffer)
DQBUF = _ioc(_READ | _WRITE, 17, Buffer)
STREAMON = _ioc(_WRITE, 18, c_int32)
STREAMOFF = _ioc(_WRITE, 19, c_int32)
G_PARM = _ioc(_READ | _WRITE, 21, StreamParm)
S_PARM = _ioc(_READ | _WRITE, 22, StreamParm)
G_STD = _ioc(_READ, 23, c_uint64)
S_STD = _ioc(_WRITE, 24, c_uint64)
ENUMINPUT = _ioc(_READ | _WRITE, 26, Input)
QUERYMENU = _ioc(_READ | _WRITE, 37, QueryMenu)
G_INPUT = _ioc(_READ, 38, c_int32)
CROPCAP = _ioc(_READ | _WRITE, 58, CropCap)
QUERYSTD = _ioc(_READ, 63, c_uint64)
G_EXT_CTRLS = _ioc(_READ | _WRITE, 71, ExtControls)
S_EXT_CTRLS = _ioc(_READ | _WRITE, 72, ExtControls)
ENUM_FRAMESIZES = _ioc(_READ | _WRITE, 74, FrameSizeEnum)
S_DV_TIMINGS = _ioc(_READ | _WRITE, 87, DvTimings)
DQEVENT = _ioc(_READ, 89, Event)
SUBSCRIBE_EVENT = _ioc(_WRITE, 90, EventSubscription)
G_SELECTION = _ioc(_READ | _WRITE, 94, Selection)
S_SELECTION = _ioc(_READ | _WRITE, 95, Selection)
QUERY_DV_TIMINGS = _ioc(_READ, 99, DvTimings)
QUERY_EXT_CTRL = _ioc(_READ | _WRITE, 103, QueryExtCtrl)


def ioctl(fd: int, number: int, argument: Any) -> None:
    """
    Call the driver; `argument` is read and written in place.

    Raises
    ------
    OSError
        With the driver's errno; a call that a signal interrupted is made again.

    """
    while True:
        try:
            fcntl.ioctl(fd, number, argument)
            return
        except InterruptedError:
            continue


_BIG_ENDIAN = '-BE'  # as v4l2-ctl writes it


def fourcc(name: str) -> int:
    """Return the number of a pixel format as `fourcc_name` gives it; 'Y16' means 'Y16 '."""
    little = name.removesuffix(_BIG_ENDIAN)
    number = int.from_bytes(little.ljust(4).encode('ascii'), 'little')
    return number | (little != name) << 31


def fourcc_name(number: int) -> str:
    """Return the four characters of a pixel format's number, without trailing spaces."""
    # The top bit marks the big-endian twin of a format.
    name = (number & 0x7fffffff).to_bytes(4, 'little').decode('ascii', 'replace').rstrip()
    return name + (_BIG_ENDIAN if number >> 31 else '')

"""The format of a V4L2 stream: what is asked for, what the driver gives, and how to read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import errno

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.errors import CaptureError
from blob_tracker.capture.fields import FieldStream, LEAST_LINES, SINGLE
from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.pixel_formats.pixel_format import Decoder, PixelData, PixelFormat
from blob_tracker.capture.pixel_formats.undecoded import advice
from blob_tracker.types import BAYER, Pixels
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class StreamFormat:
    """
    The format that a driver streams in.

    Parameters
    ----------
    buffer_type : int
        videodev2.BUF_TYPE_VIDEO_CAPTURE, or its _MPLANE twin.
    pixel_format : str
        Four-character code.
    width, height : int
        px, before any binning of the decoder.
    stride : int
        Distance of two lines of the first plane, bytes.
    saturation : int
        The DN at which a pixel of the picture is clipped.
    decoder : function
        That of the pixel format and the range of its levels.
    layout : str
        What it returns, see `blob_tracker.types.Frame`.
    binning : int
        Sensor pixels per pixel of the picture, along both axes.
    quantisation : function or None
        From the data of a compressed picture to the steps of its luma.
    fields : FieldStream
        What a buffer is of a picture.

    """

    buffer_type: int
    pixel_format: str
    width: int
    height: int
    stride: int
    saturation: int
    decoder: Decoder
    layout: str = 'grey'
    binning: int = 1
    quantisation: Callable[[PixelData], NDArray[np.uint16]] | None = None
    fields: FieldStream = field(default_factory=lambda: FieldStream('none', 0))

    def picture(self, data: PixelData) -> Pixels:
        """
        Return the picture in the first plane of a buffer.

        Raises
        ------
        ValueError
            The picture is not whole.

        """
        return self.decoder(data, self.width, self.height, self.stride)


def set_format(
    call: Ioctl, device: str, buffer_type: int, width: int, height: int, pixel_format: str,
    channel: str = 'luma', field_order: str = '', standard_lines: int = 0,
) -> StreamFormat:
    """
    Set a device to a size and a pixel format.

    Parameters
    ----------
    call : function
        videodev2.ioctl on the open device.
    device : str
        Its path, for what is said.
    buffer_type : int
        videodev2.BUF_TYPE_VIDEO_CAPTURE, or its _MPLANE twin.
    width, height : int
        px; 0 leaves it to the driver: as it is, or the nearest in another pixel format.
    pixel_format : str
        Four-character code; '' leaves it as the driver has it where that is one of
        `PIXEL_FORMATS` and not compressed. Otherwise it takes the first of these that the device
        offers, a compressed one only if there is no other.
    channel : str
        'luma', or else all colours are read: 'auto' where the format has any, a colour's name
        where they must be there.
    field_order : str
        One of `fields.CHOICES`.
    standard_lines : int
        Of the video standard of the signal, 525 or 625; 0 if there is none.

    Raises
    ------
    CaptureError
        The device does not offer it, or what it gives instead cannot be read or has no colours.
    OSError
        Of the driver.

    """
    wanted = videodev2.Format(type=buffer_type)
    call(videodev2.G_FMT, wanted)
    several = buffer_type == videodev2.BUF_TYPE_VIDEO_CAPTURE_MPLANE
    pix = wanted.pix_mp if several else wanted.pix
    name = _chosen(call, device, buffer_type, pixel_format,
                   videodev2.fourcc_name(pix.pixelformat))
    pix.width = width or pix.width
    pix.height = height or _lines_now(pix, field_order)
    pix.pixelformat = videodev2.fourcc(name)
    pix.field = videodev2.FIELDS.index(field_order or 'none')
    # How far apart lines are is the driver's choice.
    if several:
        for plane in pix.plane_fmt:
            plane.bytesperline = 0
    else:
        pix.bytesperline = 0
    asked = f'{pix.width}x{pix.height}'
    try:
        call(videodev2.S_FMT, wanted)
    except OSError as error:
        if error.errno != errno.EINVAL or field_order:
            raise
        # Some drivers of interlaced video refuse whole pictures in place of giving others.
        pix.field = videodev2.FIELDS.index('any')
        call(videodev2.S_FMT, wanted)
    # A size that nobody asked for is that of the pixel format before, which this one may not have.
    if (width and pix.width != width) or (height and pix.height != height):
        sizes = offered_sizes(call, name)
        raise CaptureError(
            f'{device}: {asked} is not offered; the driver gives '
            f'{pix.width}x{pix.height} instead' + (f', and has {sizes}' if sizes else ''))
    width, height = pix.width, pix.height
    if not (width and height):
        raise CaptureError(
            f'{device}: the driver gives pictures of {width}x{height}: there is no signal, or no '
            'program that writes into it; start that first')
    if pix.pixelformat != videodev2.fourcc(name):
        raise CaptureError(
            f'{device}: the driver gives {videodev2.fourcc_name(pix.pixelformat)} at '
            f'{width}x{height} instead of {name}; choose another size or format')
    fields = _fields(device, pix.field, field_order, width, height, standard_lines)
    plane = pix.plane_fmt[0] if several else pix
    read_as = PIXEL_FORMATS[name]
    if pix.quantization == videodev2.QUANTIZATION_LIM_RANGE and read_as.limited_range is not None:
        read_as = read_as.limited_range
    if channel not in ('auto', 'luma') and read_as.colours is None:
        raise CaptureError(
            f'{device}: channel is {channel} and {name} has no colour for each pixel; set channel '
            'to auto, or pixel_format to RGB or Bayer if the camera offers it')
    saturation = _saturation(read_as, pix.quantization, pix.colorspace)
    decoder, layout, binning = read_as.luma, 'grey', read_as.binning
    if channel != 'luma' and read_as.colours is not None:
        decoder, layout, binning = read_as.colours, read_as.layout, 1
        saturation = read_as.colour_saturation
    if fields.interlaced and (layout in BAYER or binning > 1):
        raise CaptureError(
            f'{device}: the driver gives {name} in fields, and the lines of a mosaic are none; '
            'set pixel_format to a grey format or YUV, or the source to progressive pictures')
    found = StreamFormat(
        buffer_type, name, width, height, plane.bytesperline, saturation, decoder, layout,
        binning, read_as.quantisation, fields)
    if not read_as.compressed:
        try:  # now, with a sentence, what would spoil every frame
            found.picture(bytes(plane.sizeimage))
        except ValueError as error:
            raise CaptureError(
                f'{device}: its {name} at {width}x{height} cannot be read: {error}; choose '
                'another size or format') from error
    return found


def _lines_now(
    pix: videodev2.PixFormat | videodev2.PixFormatMplane, field_order: str
) -> int:
    """Return the lines that the device is set to, in pictures or fields as they are asked for."""
    field = videodev2.FIELDS[pix.field] if pix.field < len(videodev2.FIELDS) else ''
    lines = int(pix.height)
    if (field in SINGLE) == (field_order in SINGLE):
        return lines
    return lines // 2 if field_order in SINGLE else 2 * lines


def _fields(
    device: str, given: int, wanted: str, width: int, height: int, standard_lines: int
) -> FieldStream:
    """Return what buffers hold, of a field order that the driver gives."""
    name = videodev2.FIELDS[given] if given < len(videodev2.FIELDS) else str(given)
    if name == 'any':  # against the rules; so do drivers that know no fields
        name = 'none'
    # The driver may leave to the video standard what who asks knows.
    told = name == 'interlaced' and wanted.startswith(name)
    if wanted and name != wanted and not told:
        gives = 'whole pictures' if name == 'none' else name
        raise CaptureError(
            f'{device}: fields is {wanted} and the driver gives {gives} at {width}x{height}; '
            'leave it empty to take that')
    try:
        fields = FieldStream(wanted if told else name, height, standard_lines)
    except ValueError as error:
        raise CaptureError(f'{device}: the driver gives pictures in an unknown order of fields: '
                           f'{error}') from error
    if fields.interlaced and height * fields.lines_per_line < LEAST_LINES:
        raise CaptureError(
            f'{device}: pictures of {height} lines have no fields; choose a larger size')
    return fields


def _saturation(pixel_format: PixelFormat, quantization: int, colorspace: int) -> int:
    """Return where a format clips, from the range of its levels that the driver tells."""
    full = quantization == videodev2.QUANTIZATION_FULL_RANGE or (
        quantization == videodev2.QUANTIZATION_DEFAULT
        and colorspace == videodev2.COLORSPACE_JPEG)
    if full and pixel_format.full_range_saturation is not None:
        return pixel_format.full_range_saturation
    return pixel_format.saturation


def _chosen(call: Ioctl, device: str, buffer_type: int, wanted: str, current: str) -> str:
    if wanted and wanted not in PIXEL_FORMATS:
        raise CaptureError(f'pixel_format {wanted!r} cannot be decoded; choose one of '
                           + ', '.join(PIXEL_FORMATS) + advice([wanted]))
    offered = offered_formats(call, buffer_type)
    usable = sorted(
        (name for name in offered if name in PIXEL_FORMATS),
        key=lambda name: PIXEL_FORMATS[name].compressed)  # else in the device's own order
    if not offered:
        raise CaptureError(
            f'{device}: it offers no pixel format at all: there is no signal, or no program that '
            'writes into it; start that first')
    if not usable:
        raise CaptureError(
            f'{device}: none of its pixel formats ({", ".join(offered)}) can be decoded; '
            f'one of {", ".join(PIXEL_FORMATS)} is needed{advice(offered)}')
    if wanted and wanted not in usable:
        raise CaptureError(
            f'{device}: pixel_format {wanted!r} is not offered; of the formats that this '
            f'device offers, {", ".join(usable)} can be decoded')
    if not wanted and current in usable and not PIXEL_FORMATS[current].compressed:
        return current
    return wanted or usable[0]


def offered_formats(call: Ioctl, buffer_type: int) -> list[str]:
    """Return the codes of the device's pixel formats in its own order."""
    names: list[str] = []
    while True:
        description = videodev2.FmtDesc(index=len(names), type=buffer_type)
        try:
            call(videodev2.ENUM_FMT, description)
        except OSError as error:
            if error.errno != errno.EINVAL:
                raise
            return names
        names.append(videodev2.fourcc_name(description.pixelformat))


def offered_sizes(call: Ioctl, pixel_format: str) -> str:
    """Return the device's picture sizes in words; '' where it does not list them."""
    sizes: list[str] = []
    while True:
        size = videodev2.FrameSizeEnum(
            index=len(sizes), pixel_format=videodev2.fourcc(pixel_format))
        try:
            call(videodev2.ENUM_FRAMESIZES, size)
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.ENOTTY, errno.ENODATA):
                raise
            break
        if size.type == videodev2.FRMSIZE_TYPE_DISCRETE:
            sizes.append(f'{size.min_width}x{size.max_width}')
        else:
            sizes.append(f'{size.min_width}x{size.min_height} to '
                         f'{size.max_width}x{size.max_height} in steps of '
                         f'{size.step_width}x{size.step_height}')
            break
    return ', '.join(sizes)

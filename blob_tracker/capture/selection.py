"""Which part of the sensor the frames show, and how coarsely: the selection interface of V4L2."""

from __future__ import annotations

from dataclasses import dataclass
import errno

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.errors import CaptureError

_Rectangle = tuple[int, int, int, int]  # left, top, width, height


@dataclass(frozen=True)
class SensorRegion:
    """
    The region of the sensor that frames show.

    Parameters
    ----------
    x0, y0 : int
        Place of the frame's first pixel on the full, unbinned sensor, px.
    binning : (int, int)
        Sensor pixels per pixel of the frame, along x and y.
    sensor_size : (int, int)
        Width and height of the full sensor, px.

    """

    x0: int
    y0: int
    binning: tuple[int, int]
    sensor_size: tuple[int, int]


def sensor_region(
    call: Ioctl, device: str, width: int, height: int, lines_per_line: int = 1
) -> SensorRegion:
    """
    Return the region of the sensor that frames of a size show.

    The full sensor is the driver's default rectangle, the crop lies in it, and a scaler between
    the crop and the frame is binning. Where the device knows no crop, or scales its whole sensor
    by a ratio that is not whole, the frame itself is the sensor: then the calibration is that of
    frames of this size.

    Parameters
    ----------
    call : function
        videodev2.ioctl on the open device, whose format is set.
    device : str
        Its path, for what is said.
    width, height : int
        Size of the frames, px.
    lines_per_line : int
        Lines of the sensor's picture for one of a frame: 2 where it is a field alone, which is no
        binning here.

    Raises
    ------
    CaptureError
        The crop and the frame do not fit each other in whole pixels, or the driver leaves a part
        of the frame empty.
    OSError
        Of the driver.

    """
    frame = (0, 0, width, height)
    filled = _selection(call, videodev2.SEL_TGT_COMPOSE)
    if filled and filled != frame:
        _fill(call, device, frame)
    sensor = _selection(call, videodev2.SEL_TGT_CROP_DEFAULT)
    crop = _selection(call, videodev2.SEL_TGT_CROP)
    if not sensor or not crop:
        return SensorRegion(0, 0, (1, 1), (width, lines_per_line * height))
    height *= lines_per_line
    left, top, crop_width, crop_height = crop
    x0, y0 = left - sensor[0], top - sensor[1]
    binning = crop_width // width, crop_height // height
    if (binning[0] * width, binning[1] * height) != (crop_width, crop_height):
        if crop == sensor:
            return SensorRegion(0, 0, (1, 1), (width, height))
        raise CaptureError(
            f'{device}: its crop of {crop_width}x{crop_height} is scaled to frames of '
            f'{width}x{height}, which is not a whole number of pixels each; choose frames of the '
            "crop's size, or another crop (v4l2-ctl --set-selection)")
    if x0 < 0 or y0 < 0 or x0 + crop_width > sensor[2] or y0 + crop_height > sensor[3]:
        raise CaptureError(
            f'{device}: its crop of {crop_width}x{crop_height} at ({left}, {top}) reaches beyond '
            f'the sensor of {sensor[2]}x{sensor[3]} at ({sensor[0]}, {sensor[1]}); choose '
            'another crop (v4l2-ctl --set-selection)')
    return SensorRegion(x0, y0, binning, (sensor[2], sensor[3]))


def _selection(call: Ioctl, target: int) -> _Rectangle | None:
    """Return a rectangle of the device, None if it does not know it."""
    # This type also for multi-planar devices: the kernel's rule.
    selection = videodev2.Selection(type=videodev2.BUF_TYPE_VIDEO_CAPTURE, target=target)
    try:
        call(videodev2.G_SELECTION, selection)
    except OSError as error:
        if error.errno not in (errno.ENOTTY, errno.EINVAL, errno.ENODATA):
            raise
        return None
    r = selection.r
    return (r.left, r.top, r.width, r.height) if r.width and r.height else None


def _fill(call: Ioctl, device: str, frame: _Rectangle) -> None:
    """Have the driver write the whole frame; an earlier program may have had it write a part."""
    wanted = videodev2.Selection(
        type=videodev2.BUF_TYPE_VIDEO_CAPTURE, target=videodev2.SEL_TGT_COMPOSE,
        r=videodev2.Rect(*frame))
    try:
        call(videodev2.S_SELECTION, wanted)
    except OSError as error:
        if error.errno not in (errno.ENOTTY, errno.EINVAL, errno.ERANGE):
            raise
    left, top, width, height = _selection(call, videodev2.SEL_TGT_COMPOSE) or frame
    if (left, top, width, height) != frame:
        raise CaptureError(
            f'{device}: the driver fills {width}x{height} at ({left}, {top}) of frames of '
            f'{frame[2]}x{frame[3]} alone; choose frames of that size')

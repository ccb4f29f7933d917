"""The selected input of a device and the signal on it: HDMI, SDI, and analogue grabbers."""

from __future__ import annotations

import ctypes
import errno

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.errors import CaptureError

_NO_SIGNAL = (videodev2.IN_ST_NO_POWER | videodev2.IN_ST_NO_SIGNAL
              | videodev2.IN_ST_NO_H_LOCK | videodev2.IN_ST_NO_SYNC)
_TIMINGS_ERRORS = {
    errno.ENOLINK: 'no signal: connect the source and switch it on',
    errno.ENOLCK: 'a signal it cannot lock to: check the cable and the source',
    errno.ERANGE: 'a signal out of its range: choose a lower resolution or rate at the source',
}

# By the lines of the standard: those of a field that show a picture, and the height of a pixel by
# its width where lines are sampled at 13.5 MHz (ITU-R BT.601)
_ACTIVE_LINES = {525: 240, 625: 288}
_ASPECTS = {525: 11 / 10, 625: 54 / 59}


class Signal:
    """
    The input that a device is switched to.

    Parameters
    ----------
    ioctl : function
        (number, argument) -> None, calls the driver.

    Attributes
    ----------
    frame_rate : float
        Of the timings or the video standard that `lock` found, pictures/s; 0 if there is none.
    lines : int
        Of the video standard that `lock` found, 525 or 625; 0 if there is none.

    Raises
    ------
    OSError
        ENODEV where the device is gone.

    """

    def __init__(self, ioctl: Ioctl) -> None:
        self.frame_rate = 0.0
        self.lines = 0
        self._call = ioctl
        self._input = videodev2.Input()  # stays empty if the driver knows no inputs
        try:
            index = ctypes.c_int32()
            ioctl(videodev2.G_INPUT, index)
            self._input.index = index.value
            ioctl(videodev2.ENUMINPUT, self._input)
        except OSError as error:
            if error.errno not in (errno.ENOTTY, errno.EINVAL):
                raise

    def lock(self, device: str) -> None:
        """
        Set an input with digital timings, or an analogue one, to those of its signal.

        Raises
        ------
        CaptureError
            There is no signal, or none that can be taken; `device` is named.

        """
        if self._input.std or self._input.capabilities & videodev2.IN_CAP_STD:
            self._find_standard()
        if not self._input.capabilities & videodev2.IN_CAP_DV_TIMINGS:
            return
        timings = videodev2.DvTimings()
        try:
            self._call(videodev2.QUERY_DV_TIMINGS, timings)
        except OSError as error:
            if error.errno not in _TIMINGS_ERRORS:
                raise
            raise CaptureError(
                f'{device}: input {self._name} has {_TIMINGS_ERRORS[error.errno]}') from error
        self._call(videodev2.S_DV_TIMINGS, timings)
        bt = timings.bt
        # The height is that of the picture; blanking is that of each field.
        total = ((bt.width + bt.hfrontporch + bt.hsync + bt.hbackporch)
                 * (bt.height + bt.vfrontporch + bt.vsync + bt.vbackporch
                    + bt.il_vfrontporch + bt.il_vsync + bt.il_vbackporch))
        self.frame_rate = bt.pixelclock / total if total else 0.0

    @property
    def readout_time(self) -> float | None:
        """Return how long the lines of a field take to come, s; None without a standard."""
        if not self.lines:
            return None
        return _ACTIVE_LINES[self.lines] / (self.lines * self.frame_rate)

    def pixel_aspect(self, width: int, height: int) -> float:
        """
        Return the height of a pixel by its width.

        Parameters
        ----------
        width, height : int
            Pixels in which the driver gives its whole picture.

        """
        found = videodev2.CropCap(type=videodev2.BUF_TYPE_VIDEO_CAPTURE)
        try:
            self._call(videodev2.CROPCAP, found)
        except OSError as error:
            if error.errno not in (errno.ENOTTY, errno.EINVAL, errno.ENODATA):
                raise
        aspect, sampled = found.pixelaspect, (found.defrect.width, found.defrect.height)
        ratio = aspect.numerator / aspect.denominator if aspect.denominator else 0.0
        if self.lines and not (ratio and all(sampled)):
            ratio, sampled = _ASPECTS[self.lines], (720, 2 * _ACTIVE_LINES[self.lines])
        if not ratio or not all(sampled):
            return 1.0
        return ratio * (sampled[1] / height) / (sampled[0] / width)

    def _find_standard(self) -> None:
        """Set an analogue input to the standard of its signal, if that is seen; note its lines."""
        standard, seen = ctypes.c_uint64(), ctypes.c_uint64()
        try:
            self._call(videodev2.G_STD, standard)
        except OSError as error:
            if error.errno not in (errno.ENOTTY, errno.EINVAL, errno.ENODATA):
                raise
            return
        try:
            self._call(videodev2.QUERYSTD, seen)
            if seen.value and not seen.value & standard.value:
                self._call(videodev2.S_STD, seen)
                standard = seen
        except OSError as error:
            if error.errno == errno.ENODEV:
                raise  # else it cannot tell, or not now: as it is set
        of_525 = bool(standard.value & videodev2.STD_525_60)
        if of_525 != bool(standard.value & videodev2.STD_625_50):  # not all of them at once
            self.lines = 525 if of_525 else 625
            self.frame_rate = 30000 / 1001 if of_525 else 25.0

    def trouble(self) -> str:
        """Return ': ' and what is wrong with the signal of a camera that has gone quiet, or ''."""
        try:
            self._call(videodev2.ENUMINPUT, self._input)
            if self._input.status & _NO_SIGNAL:
                return f': input {self._name} has {_TIMINGS_ERRORS[errno.ENOLINK]}'
            if self._input.capabilities & videodev2.IN_CAP_DV_TIMINGS:
                self._call(videodev2.QUERY_DV_TIMINGS, videodev2.DvTimings())
        except OSError as error:
            if error.errno == errno.ENODEV:
                return ': the device is gone (unplugged?)'
            if error.errno in _TIMINGS_ERRORS:
                return f': input {self._name} has {_TIMINGS_ERRORS[error.errno]}'
        return ''

    @property
    def _name(self) -> str:
        return str(self._input.name.decode(errors='replace'))

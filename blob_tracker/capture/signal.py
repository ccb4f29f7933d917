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
        Of the timings that `lock` found, frames/s; 0 where there are none.

    Raises
    ------
    OSError
        ENODEV where the device is gone.

    """

    def __init__(self, ioctl: Ioctl) -> None:
        self.frame_rate = 0.0
        self._call = ioctl
        self._input = videodev2.Input()  # stays empty where the driver knows no inputs
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
        Set an input with digital timings to those of its signal.

        Raises
        ------
        CaptureError
            There is no signal, or none that can be taken; `device` is named.

        """
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
        if timings.bt.interlaced:
            raise CaptureError(
                f'{device}: the signal on input {self._name} is interlaced; the source must send '
                'whole (progressive) pictures')
        self._call(videodev2.S_DV_TIMINGS, timings)
        bt = timings.bt
        total = ((bt.width + bt.hfrontporch + bt.hsync + bt.hbackporch)
                 * (bt.height + bt.vfrontporch + bt.vsync + bt.vbackporch))
        self.frame_rate = bt.pixelclock / total if total else 0.0

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

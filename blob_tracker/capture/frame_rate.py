"""The frame rate, as drivers know it: a fraction of a second from frame to frame."""

from __future__ import annotations

import errno
from fractions import Fraction

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl


def set_frame_rate(
    call: Ioctl, buffer_type: int, wanted: float, of_signal: float
) -> float:
    """
    Ask for a frame rate; return the one that the driver gives, frames/s, 0 if unknown.

    Parameters
    ----------
    call : function
        Takes the number and the argument of an ioctl of the device.
    buffer_type : int
        Of its buffers.
    wanted : float
        Frames/s; 0 leaves it as the driver has it.
    of_signal : float
        Frames/s of a video signal, where the driver does not tell; 0 without one.

    Raises
    ------
    OSError
        The device fails.

    """
    parameters = videodev2.StreamParm(type=buffer_type)
    try:
        call(videodev2.G_PARM, parameters)
        if wanted > 0.0 and parameters.capability & videodev2.CAP_TIMEPERFRAME:
            rate = _rate(wanted)
            parameters.timeperframe.numerator = rate.denominator
            parameters.timeperframe.denominator = rate.numerator
            call(videodev2.S_PARM, parameters)
    except OSError as error:
        if error.errno not in (errno.ENOTTY, errno.EINVAL):
            raise
        return of_signal
    interval = parameters.timeperframe
    if not (interval.numerator and interval.denominator):
        return of_signal
    return interval.denominator / interval.numerator


def _rate(wanted: float) -> Fraction:
    """Return a frame rate as the fraction that drivers know it by, frames/s."""
    # 29.97 and 59.94 are short for 30000/1001 and 60000/1001; low whole rates lie near such too.
    broadcast = Fraction(round(wanted * 1.001) * 1000, 1001)
    if wanted != round(wanted) and abs(wanted - broadcast) <= 0.01:
        return broadcast
    return Fraction(wanted).limit_denominator(1001)

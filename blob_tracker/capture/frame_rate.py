"""The frame rate, as drivers know it: a fraction of a second from frame to frame; and as it is."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
import errno
from fractions import Fraction

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Control, ControlError, get_control, Ioctl

MEASURED_OVER = 64  # frames
BLANKING = (videodev2.CID_HBLANK, videodev2.CID_VBLANK, videodev2.CID_PIXEL_RATE)
ENOUGH = 20  # frames: a stamp that is late by half an interval is off by 3 % then


def frame_interval(call: Ioctl, buffer_type: int) -> Fraction | None:
    """
    Return the time from frame to frame that a driver is set to, s; None if it does not tell.

    Raises
    ------
    OSError
        The device fails.

    """
    parameters = videodev2.StreamParm(type=buffer_type)
    try:
        call(videodev2.G_PARM, parameters)
    except OSError as error:
        if error.errno not in (errno.ENOTTY, errno.EINVAL):
            raise
        return None
    return _fraction(parameters.timeperframe)


def set_frame_rate(
    call: Ioctl, buffer_type: int, wanted: float, of_signal: float,
    before: Fraction | None = None,
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
        Frames/s; 0 leaves it as it was.
    of_signal : float
        Frames/s of a video signal, where the driver does not tell; 0 without one.
    before : Fraction or None
        `frame_interval` before the format was set, by which some drivers, as uvcvideo, fall back
        to the rate that the format has by default; None if that is not known.

    Raises
    ------
    OSError
        The device fails.

    """
    parameters = videodev2.StreamParm(type=buffer_type)
    interval = 1 / _rate(wanted) if wanted > 0.0 else before
    try:
        call(videodev2.G_PARM, parameters)
        now = parameters.timeperframe
        if (
            interval is not None and parameters.capability & videodev2.CAP_TIMEPERFRAME
            and interval != _fraction(now)
        ):
            now.numerator, now.denominator = interval.numerator, interval.denominator
            call(videodev2.S_PARM, parameters)
    except OSError as error:
        if error.errno not in (errno.ENOTTY, errno.EINVAL):
            raise
        return of_signal
    given = _fraction(parameters.timeperframe)
    return of_signal if given is None else float(1 / given)


def _fraction(interval: videodev2.Fract) -> Fraction | None:
    if not (interval.numerator and interval.denominator):
        return None
    return Fraction(interval.numerator, interval.denominator)


def _rate(wanted: float) -> Fraction:
    """Return a frame rate as the fraction that drivers know it by, frames/s."""
    # 29.97 and 59.94 are short for 30000/1001 and 60000/1001; low whole rates lie near such too.
    broadcast = Fraction(round(wanted * 1.001) * 1000, 1001)
    if wanted != round(wanted) and abs(wanted - broadcast) <= 0.01:
        return broadcast
    return Fraction(wanted).limit_denominator(1001)


def blanking_rate(
    call: Ioctl, known: Mapping[str, Control], width: int, height: int
) -> float | None:
    """
    Return the frames/s of a sensor by its controls; None if it has not all of them.

    It is pixel_rate / ((width + hblank) (height + vblank)).

    Parameters
    ----------
    call : function
        As that of `controls.controls`.
    known : mapping of str to Control
        The controls that there are.
    width, height : int
        The picture, px.

    """
    numbers = {control.number: control for control in known.values()}
    try:
        across, down, pixel_rate = (
            int(get_control(call, numbers[number])) for number in BLANKING)
    except (KeyError, ControlError):
        return None
    return pixel_rate / ((width + across) * (height + down))


class MeasuredRate:
    """The frame rate by the driver's numbers and stamps: what was lost on the way counts too."""

    def __init__(self) -> None:
        self._last: deque[tuple[int, int]] = deque(maxlen=MEASURED_OVER)

    def add(self, number: int, stamp_ns: int) -> None:
        """Take the next frame: the driver's number, and its stamp in ns."""
        if self._last and number <= self._last[-1][0]:
            self._last.clear()  # it counts anew
        self._last.append((number, stamp_ns))

    @property
    def rate(self) -> float:
        """Return the frames/s of the last frames; 0 while there are too few."""
        if not self._last:
            return 0.0
        (first, begin_ns), (last, end_ns) = self._last[0], self._last[-1]
        if last - first < ENOUGH or end_ns <= begin_ns:
            return 0.0
        return 1e9 * (last - first) / (end_ns - begin_ns)

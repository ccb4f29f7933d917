"""
The driver's stamp of a frame -> the middle of its exposure.

What a driver stamps is one of three instants, and its flags do not tell them apart:

- the start of the exposure: V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
- the end of the frame's transfer: no such flag (EOF), most drivers;
- the start of the transfer, that of the first line, without a flag for it: `unicam` and `rp1-cfe`,
  the receivers of a Raspberry Pi, in their interrupt at the start of a frame;
- the start of the transfer: `uvcvideo`, which sets the flag of the first. It takes the time when
  the first data of a frame arrive, which a sensor can only send once it has exposed its first
  line; of a camera that sends headers without data meanwhile, the time when the frame before
  ended. (Its module option `hwtimestamps=1` makes it compute the start of the exposure from the
  camera's own clock, where the camera tells that: the flag is true then, and else it is not. Which
  of the two it is, its metadata tell: `uvc_clock`.)

`vivid` has a picture ready when its frame begins, and stamps it with an end that is still to come
(0.9 of the interval later). No light arrives after it is read: such stamps are cut at the time
of reading.

A rolling shutter exposes each line at its own time: the middle is that of the line that is
exposed first.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
import threading
from typing import Literal

from blob_tracker.capture import videodev2
from blob_tracker.capture.auto_modes import governed_exposures
from blob_tracker.capture.controls import Control, ControlError, get_control, Ioctl

Source = Literal[
    'exposure start', 'camera clock', 'transfer start', 'frame start', 'transfer end']

SHARES = 20  # frames whose transfer is looked at; a busy reader takes some of them up late
LONGEST_TRANSFER = 0.8  # of the interval of frames
FROM_THE_START = 'exposure start', 'camera clock'
AT_THE_FIRST_LINE = 'unicam', 'rp1-cfe'  # drivers that stamp the start of the transfer
EXPOSURE_UNIT_NS = 100_000  # of V4L2_CID_EXPOSURE_ABSOLUTE
AUTOMATIC = (0, 3)  # V4L2_EXPOSURE_AUTO and _APERTURE_PRIORITY: the camera chooses the time
WATCHED = (videodev2.CID_EXPOSURE, videodev2.CID_EXPOSURE_ABSOLUTE, videodev2.CID_EXPOSURE_AUTO,
           videodev2.CID_HBLANK, videodev2.CID_PIXEL_RATE)
HARDWARE_STAMPS = Path('/sys/module/uvcvideo/parameters/hwtimestamps')


@dataclass(frozen=True)
class Exposure:
    """
    How long a frame is exposed and read out; None if it is not known.

    Parameters
    ----------
    time_ns : int or None
        Exposure of a line, ns.
    readout_ns : int or None
        From the end of the first line's exposure to the end of the transfer, ns.
    line_ns : float or None
        From the exposure of a line that the sensor reads to that of the next, ns; of a sensor
        with a global shutter how long it takes to read a line.

    """

    time_ns: int | None = None
    readout_ns: int | None = None
    line_ns: float | None = None


def source_of(buffer_flags: int, driver: str) -> Source:
    """Return which instant a driver stamps."""
    if driver in AT_THE_FIRST_LINE:
        return 'frame start'
    marked = buffer_flags & videodev2.BUF_FLAG_TSTAMP_SRC_MASK
    if marked != videodev2.BUF_FLAG_TSTAMP_SRC_SOE:
        return 'transfer end'
    if driver == 'uvcvideo':
        return 'camera clock' if _hardware_stamps() else 'transfer start'
    return 'exposure start'


def _hardware_stamps() -> bool:
    try:
        return HARDWARE_STAMPS.read_text().strip() not in ('', '0', 'N')
    except OSError:
        return False


def place(source: Source, exposure: Exposure, *, pauses: bool = True) -> str:
    """
    Return in words the instant that a stamp names, after all that is known is applied.

    Parameters
    ----------
    source : str
        The instant that is stamped.
    exposure : Exposure
        As it is set.
    pauses : bool
        Whether nothing is sent between frames, as far as the stamps tell.

    """
    if source == 'transfer start' and not pauses:
        return ('start of the transfer, or the end of that before, as the camera seems to send '
                'without a pause')
    after = {
        'exposure start': '',
        'frame start': '',
        'camera clock': ', if the camera sends its own time, else near the start of the transfer',
        'transfer start': ', as far as the camera sends it at once',
        'transfer end': '' if exposure.readout_ns is not None else
        ', later by the time of the readout, which is unknown and taken as 0',
    }[source]
    if exposure.time_ns is not None:
        return 'middle of the exposure' + after
    if source in FROM_THE_START:
        return f'start of the exposure, whose length is unknown{after}'
    return f'end of the exposure, whose length is unknown{after}'


def of_first_line(line_time_ns: float, height: int, binning: int) -> int:
    """
    Return how much later than the line that is exposed first a frame's first line is, ns.

    Parameters
    ----------
    line_time_ns : float
        From the exposure of a line of the frame to that of the next, ns; below 0 where the last
        one is exposed first.
    height : int
        Lines of the frame.
    binning : int
        Lines that the sensor reads for one of the frame's.

    """
    before = 0 if line_time_ns >= 0.0 else height - 1
    return round(abs(line_time_ns) * (before + 0.5 - 0.5 / binning))


class MidExposure:
    """
    The middle of a frame's exposure from its stamp, while the exposure time changes.

    With the exposure time t and the readout time r the middle is
        stamp + t/2        where the start of the exposure is stamped,
        stamp - t/2        where the start of the transfer is stamped,
        stamp - r - t/2    where the end of the transfer is stamped.
    What is unknown counts as 0 (see `place`).

    A change holds from the first frame on whose exposure begins after it. A sensor that takes it
    a frame or two later has the stamps of those frames off by half the change.

    Middles grow from frame to frame whatever the driver says, and none is later than its reading.

    Parameters
    ----------
    source : str
        The instant that is stamped.
    exposure : Exposure
        At the first frame.

    """

    def __init__(self, source: Source, exposure: Exposure) -> None:
        self._source = source
        self._changes = [(0, exposure)]  # (since, exposure), the oldest is in use
        self._last_ns = 0
        self._stamp_ns = 0
        self._shares: deque[float] = deque(maxlen=SHARES)
        self._lock = threading.Lock()

    @property
    def place(self) -> str:
        """Return in words the instant that stamps name."""
        return place(self._source, self.exposure, pauses=self._pauses())

    @property
    def exposure(self) -> Exposure:
        """Return the exposure that was set last."""
        return self._changes[-1][1]

    @property
    def time_ns(self) -> int:
        """Return how long the last frame was exposed, ns; 0 where that is not known."""
        return self._changes[0][1].time_ns or 0

    @property
    def line_ns(self) -> float | None:
        """Return how long a line of the last frame took, ns; None if it is not known."""
        return self._changes[0][1].line_ns

    def camera_clock(self, told: bool | None) -> None:
        """Know whether the camera sends its own time, which is then that of the stamps."""
        if self._source == 'camera clock' and told is not None:
            self._source = 'exposure start' if told else 'transfer start'

    def changed(self, since_ns: int, exposure: Exposure) -> None:
        """Take another exposure for frames that begin at `since_ns`, monotonic, or later."""
        with self._lock:
            self._changes.append((since_ns, exposure))

    def middle(self, stamp_ns: int, read_ns: int) -> int:
        """
        Return the middle of the exposure, monotonic ns, of the next frame.

        Parameters
        ----------
        stamp_ns : int
            The driver's stamp, monotonic ns.
        read_ns : int
            When the frame was read, monotonic ns.

        """
        with self._lock:
            # The newest change that was made before the exposure began; the first always was.
            for index in range(len(self._changes) - 1, -1, -1):
                since, exposure = self._changes[index]
                begin, middle = self._exposed(stamp_ns, exposure)
                if begin >= since:
                    break
            del self._changes[:index]
        if 0 < self._stamp_ns < stamp_ns:
            self._shares.append((read_ns - stamp_ns) / (stamp_ns - self._stamp_ns))
        self._stamp_ns = stamp_ns
        self._last_ns = max(self._last_ns + 1, min(middle, read_ns))
        return self._last_ns

    def _pauses(self) -> bool:
        """
        Return whether there are pauses between frames.

        Of a camera that fills them with headers uvcvideo stamps the first header: as the frame
        before has ended, a whole interval before the frame is read.
        """
        shares = sorted(self._shares)
        return len(shares) < SHARES or shares[SHARES // 4] < LONGEST_TRANSFER

    def _exposed(self, stamp_ns: int, exposure: Exposure) -> tuple[int, int]:
        """Return the start and the middle of an exposure, monotonic ns."""
        time_ns = exposure.time_ns or 0
        if self._source in FROM_THE_START:
            begin = stamp_ns
        elif self._source in ('transfer start', 'frame start'):
            begin = stamp_ns - time_ns
        else:
            begin = stamp_ns - (exposure.readout_ns or 0) - time_ns
        return begin, begin + time_ns // 2


class ExposureControls:
    """
    The exposure as the controls of a device have it, followed while they change.

    Exposure time: V4L2_CID_EXPOSURE_ABSOLUTE in units of 100 us; else V4L2_CID_EXPOSURE in lines
    of (width + hblank) / pixel_rate seconds, which also gives the readout of `height` lines. An
    automatic exposure is unknown, as are other units of V4L2_CID_EXPOSURE.

    Parameters
    ----------
    ioctl : function
        As that of `controls.controls`.
    found : mapping of str to Control
        The device's controls.
    width, height : int
        The picture that the sensor reads out, px.
    otherwise : Exposure
        What holds where the device does not tell.

    """

    def __init__(
        self, ioctl: Ioctl, found: Mapping[str, Control], width: int, height: int,
        otherwise: Exposure,
    ) -> None:
        self._ioctl = ioctl
        self._controls = {
            control.number: control for control in found.values() if control.number in WATCHED}
        self._width, self._height = width, height
        self._otherwise = otherwise

    def governed_by(self, number: int) -> bool:
        """Return whether the exposure depends on the control of this number."""
        return number in self._controls

    def read(self) -> Exposure:
        """
        Return the exposure that is set now.

        Raises
        ------
        OSError
            ENODEV where the device is gone.

        """
        line_ns = self._line_ns()
        readout_ns = self._otherwise.readout_ns
        if readout_ns is None and line_ns is not None:
            readout_ns = round(self._height * line_ns)
        time_ns = self._time_ns(line_ns)
        return Exposure(
            self._otherwise.time_ns if time_ns is None else time_ns, readout_ns, line_ns
        )

    def unit_ns(self) -> float | None:
        """
        Return one unit of the control of the exposure, ns; None if it is unknown.

        Raises
        ------
        OSError
            ENODEV where the device is gone.

        """
        if videodev2.CID_EXPOSURE_ABSOLUTE in self._controls:
            return EXPOSURE_UNIT_NS
        return self._line_ns() if videodev2.CID_EXPOSURE in self._controls else None

    def _time_ns(self, line_ns: float | None) -> int | None:
        automatic = self._value(videodev2.CID_EXPOSURE_AUTO) in AUTOMATIC
        if automatic or governed_exposures(self._controls.values()):
            return None
        units = self._value(videodev2.CID_EXPOSURE_ABSOLUTE)
        if units is not None:
            return units * EXPOSURE_UNIT_NS
        lines = self._value(videodev2.CID_EXPOSURE)
        return None if lines is None or line_ns is None else round(lines * line_ns)

    def _line_ns(self) -> float | None:
        blanking = self._value(videodev2.CID_HBLANK)
        rate = self._value(videodev2.CID_PIXEL_RATE)
        return None if blanking is None or not rate else (self._width + blanking) * 1e9 / rate

    def _value(self, number: int) -> int | None:
        control = self._controls.get(number)
        if control is None:
            return None
        try:
            value = get_control(self._ioctl, control)
        except ControlError:
            return None
        return value if isinstance(value, int) else None

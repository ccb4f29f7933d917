"""A V4L2 camera: kernel buffers -> Frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import os
import time
from types import TracebackType

from blob_tracker.capture import controls, videodev2
from blob_tracker.capture.buffers import stamp_of, told_stamp
from blob_tracker.capture.clock import RealtimeClock
from blob_tracker.capture.control_events import ControlEvents
from blob_tracker.capture.controls import Control
from blob_tracker.capture.device import buffer_type, driver, open_capture_device
from blob_tracker.capture.device_controls import DeviceControls
from blob_tracker.capture.errors import CaptureError
from blob_tracker.capture.field_dealer import FieldDealer
from blob_tracker.capture.fields import FieldStream
from blob_tracker.capture.format import set_format
from blob_tracker.capture.frame_count import FrameCount
from blob_tracker.capture.frame_rate import (
    BLANKING, blanking_rate, frame_interval, set_frame_rate,
)
from blob_tracker.capture.low_bits import FULL, LowBits
from blob_tracker.capture.refusals import LOOPBACK, refusal, Step
from blob_tracker.capture.ring import Ring
from blob_tracker.capture.selection import sensor_region
from blob_tracker.capture.signal import Signal
from blob_tracker.capture.stamps import (
    Exposure, ExposureControls, MidExposure, of_first_line, source_of,
)
from blob_tracker.capture.uvc_clock import UvcClock
from blob_tracker.types import Frame


class V4l2Camera:
    """
    A V4L2 capture device, opened, configured and streaming; close it or use it in a `with`.

    Frames come in the order in which the sensor took them, because a flash is seen in the
    difference of neighbours. They wait in the driver's ring of `buffers`; a frame that waited
    there for longer than the ring is long (`buffers` times the frame interval) is left out and
    counted in `drops`: after a stall of the reader the first frame is a new one, and a reader that
    is too slow never falls further behind than that.

    The controls are those of the device and, behind a media controller, of the sensor and the
    other subdevices that feed it.

    An HDMI or SDI input is set to the timings of its signal first, an analogue one to the standard
    of its signal where the driver tells.

    Of interlaced pictures each field is a frame, with a stamp and a place of its own: see
    `blob_tracker.capture.fields`.

    Parameters
    ----------
    device : str
        Path of the device or a link to it.
    width, height : int
        px; 0 leaves it to the driver: as it is, or the nearest in another pixel format.
    pixel_format : str
        Four-character code, one of `PIXEL_FORMATS`; '' leaves it as the driver has it where that
        is one of these and not compressed. Otherwise it takes the first of these that the device
        offers, a compressed one only if there is no other.
    frame_rate : float
        Frames/s, of interlaced pictures fields/s; 0 leaves it as it was, whatever the driver does
        to it when the format is set. The driver takes the nearest it can.
    buffers : int
        Kernel buffers, 2 to 32.
    exposure_time : float or None
        s; of a camera whose controls do not tell.
    readout_time : float or None
        s from the end of the exposure to the end of the transfer, of a camera whose driver
        stamps the latter and whose controls do not tell.
    line_time : float or None
        s from the exposure of a line of the frames to that of the next, below 0 where the last
        one is exposed first; 0 of a global shutter. None takes it from the device's controls, as
        far as they tell, for a sensor with a rolling shutter.
    prepare : function
        Called with the camera when its format is set and no frame has come yet: drivers lock some
        controls while they stream.
    channel : str
        'luma' gives grey frames; 'auto' those with all the colours that the pixel format has for
        each pixel; 'red', 'green' and 'blue' the same where it has any.
    fields : str
        How interlaced pictures are asked for, one of `blob_tracker.capture.fields.CHOICES`; ''
        takes whole pictures where the driver has them, and otherwise what it gives. An order
        counts for a driver that leaves it to the video standard, too.

    Attributes
    ----------
    width, height : int
        Size that the driver gives, px; the luma of a Bayer format is half as wide and high, a
        field of an interlaced picture less than half as high.
    sensor : str
        Name and subdevices of the sensor behind a media controller; '' without one.
    sensor_size : (int, int)
        Width and height of the full, unbinned sensor, px, as far as the driver tells; otherwise
        those of its pictures. `Frame.x0`, `y0` and `binning` are the place in it.
    frame_rate : float
        Frames/s, as the driver gives it, of interlaced pictures fields/s; 0 where it does not say.
    pixel_aspect : float
        Height of a pixel of the full sensor by its width, as far as the driver tells: lines of an
        analogue camera are sampled at a rate of their own.
    pixel_format : str
        Four-character code in use.
    saturation : int
        The DN at which its pixels are clipped; of words of 16 bits by the pictures read so far
        (`blob_tracker.capture.low_bits`).
    drops : int
        Frames lost between those read, error frames too; see `frame_count.FrameCount`.
    error_frames : int
        Pictures that the driver marked as spoilt or that were cut short.
    sequence : int
        The driver's number of the frame read last.
    control_changes : int
        Changes of controls that others made, as far as frames were read since.

    Raises
    ------
    CaptureError
        The device cannot be opened or does not offer what was asked for.

    Examples
    --------
    The first camera of this machine, and a frame of it:

    >>> with V4l2Camera('/dev/video0', 640, 480, frame_rate=30.0) as camera:  # doctest: +SKIP
    ...     frame = camera.read(timeout=1.0)
    ...     print(camera.pixel_format, camera.frame_rate, frame.image.shape)
    YUYV 30.0 (480, 640)

    """

    error_frames = 0
    sequence = -1
    control_changes = 0
    sensor = ''
    _driver = ''
    _by_blanking = False
    _since_ns = 0  # monotonic; what is stamped earlier is left out
    _uvc_clock: UvcClock | None = None

    def __init__(
        self,
        device: str,
        width: int = 0,
        height: int = 0,
        pixel_format: str = '',
        frame_rate: float = 0.0,
        buffers: int = 4,
        exposure_time: float | None = None,
        readout_time: float | None = None,
        line_time: float | None = 0.0,
        prepare: Callable[[V4l2Camera], None] = lambda camera: None,
        channel: str = 'luma',
        fields: str = '',
    ) -> None:
        if not 2 <= buffers <= 32:
            raise CaptureError(f'buffers is {buffers}; it must be 2 to 32')
        for name, seconds in (('exposure_time', exposure_time), ('readout_time', readout_time)):
            if seconds is not None and not 0.0 <= seconds < float('inf'):
                raise CaptureError(f'{name} is {seconds} s; it must be 0 or more')
        if line_time is not None and not abs(line_time) < float('inf'):
            raise CaptureError(f'line_time is {line_time} s; it must be finite')
        self.device = device
        self._given_line_time = line_time
        self._clock = RealtimeClock()
        self._controls = DeviceControls(device, self._call)
        self._fd = open_capture_device(device)
        self._ring = Ring(self._call, self._fd, device, self._trouble)
        step: Step = 'settings'
        try:
            self._driver = driver(self._fd)
            self._controls.find_sensor(self._fd)
            self.sensor = self._controls.sensor
            self._signal = Signal(self._call)
            self._signal.lock(device)
            kind = buffer_type(self._fd)
            interval = frame_interval(self._call, kind)
            self._format = set_format(
                self._call, device, kind, width, height, pixel_format,
                channel, fields, self._signal.lines)
            self.pixel_format = self._format.pixel_format
            self.saturation = self._format.saturation
            self._low_bits = LowBits(self._format.binning)
            self.width, self.height = self._format.width, self._format.height
            self._region = sensor_region(
                self._call, device, self.width, self.height, self.fields.lines_per_line)
            self.sensor_size = self._region.sensor_size
            self.pixel_aspect = self._signal.pixel_aspect(*self.sensor_size)
            across, down = self._region.binning
            self._binning = across * self._format.binning, down * self._format.binning
            # Drivers count pictures.
            per_picture = self.fields.per_picture
            self.frame_rate = per_picture * set_frame_rate(
                self._call, kind, frame_rate / per_picture, self._signal.frame_rate, interval)
            prepare(self)
            step = 'buffers'
            buffer_flags = self._ring.map_in(self._format.buffer_type, buffers)
            step = 'stream'
            known = self._controls.found()
            self._by_blanking = not self.frame_rate
            self._follow_blanking(known)
            self._events = ControlEvents(self._controls.call, known.values())
            self._exposure = ExposureControls(
                self._controls.call, known, self.width * self._format.binning,
                self.height * self._format.binning,
                Exposure(
                    _ns(exposure_time),
                    _ns(self._signal.readout_time if readout_time is None else readout_time)))
            source = source_of(buffer_flags, self._driver)
            self._middle = MidExposure(source, self._exposure.read())
            self._dealer = FieldDealer(self.fields, stamps_end=source == 'transfer end')
            self._count = FrameCount(numbered=self._driver != 'uvcvideo')
            if self._driver == LOOPBACK:
                # Version 0.12 numbers and stamps the pictures that it has anew as buffers are
                # asked for: the first one would be number 0, and the next one thousands later.
                self._since_ns = time.monotonic_ns()
            self._ring.start()
            if source == 'camera clock':
                self._uvc_clock = UvcClock(self._fd)
        except OSError as error:
            self.close()
            raise CaptureError(refusal(device, self._driver, step, error)) from error
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> V4l2Camera:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def read(self, timeout: float = 1.0) -> Frame:
        """
        Return the next complete frame; wait for it for `timeout` seconds at most.

        Its stamp is the middle of the exposure of its first line in ROS time, as far as that can
        be known (see `stamp_place` and `blob_tracker.capture.stamps`). Pictures that the driver
        marks as spoilt and pictures that are cut short are left out.

        Raises
        ------
        NoFrameError
            No frame came in time; the camera may be read again.
        CaptureError
            The device is gone or has stopped; it has to be opened again.

        """
        self._controls.check_open()
        self._dealer.drop_old(self.longest_wait)
        if not self._dealer.waiting:
            self._next_picture(timeout)
        return self._dealer.waiting.popleft()

    @property
    def fields(self) -> FieldStream:
        """Return what the driver's buffers hold of a picture; as a str in words."""
        return self._format.fields

    @property
    def drops(self) -> int:
        """Return how many frames were lost between those read, error frames too."""
        return self.fields.per_buffer * self._count.lost + self._dealer.passed_over

    @property
    def stamp_place(self) -> str:
        """Return in words the instant that a frame's stamp names, with the controls as set."""
        return self._middle.place

    @property
    def exposure_time(self) -> float | None:
        """Return how long a frame is exposed, s, with the controls as set; None if unknown."""
        time_ns = self._middle.exposure.time_ns
        return None if time_ns is None else time_ns / 1e9

    @property
    def line_time(self) -> float | None:
        """Return s from the exposure of a line of the frames to that of the next, if known."""
        if self._given_line_time is not None:
            return self._given_line_time
        return self.read_time

    @property
    def read_time(self) -> float | None:
        """Return how long the sensor reads a line of the frames, s, if its controls tell."""
        line_ns = self._middle.exposure.line_ns
        return None if line_ns is None else self._format.binning * line_ns / 1e9

    @property
    def exposure_unit(self) -> float | None:
        """Return one unit of the exposure control, s; None if it is unknown."""
        unit_ns = self._controls.guarded(self._exposure.unit_ns)
        return None if unit_ns is None else unit_ns / 1e9

    @property
    def tells_changes(self) -> bool:
        """Return whether `control_changes` counts: not all drivers tell."""
        return self._events.told

    @property
    def measured_rate(self) -> float:
        """Return the frames/s by the driver's numbers and stamps; 0 while that is unknown."""
        return self.fields.per_buffer * self._count.rate

    @property
    def longest_wait(self) -> float:
        """Return how long a frame may wait and still be new, s; 0 while that is unknown."""
        return len(self._ring) * self._count.interval_ns / 1e9

    @property
    def controls(self) -> dict[str, Control]:
        """
        Return the device's controls as the driver has them now: name -> control.

        Raises
        ------
        CaptureError
            The device is gone, or closed.

        """
        return self._controls.guarded(self._controls.found)

    def get_control(self, name: str | Control) -> int | str:
        """
        Return the value of a control; one of `controls` is not looked up again.

        Raises
        ------
        ControlError
            There is no such control, or it cannot be read.
        CaptureError
            The device is gone, or closed.

        """
        return self._controls.guarded(
            lambda: controls.get_control(self._controls.call, self._controls.named(name)))

    def set_control(self, name: str | Control, value: int | bool | float | str) -> None:
        """
        Set a control; see `blob_tracker.capture.controls.set_control` for the values.

        One of `controls` is not looked up again.

        Raises
        ------
        ControlError
            There is no such control, it may not have this value, or not now.
        CaptureError
            The device is gone, or closed.

        """
        def change() -> None:
            control = self._controls.named(name)
            controls.set_control(self._controls.call, control, value)
            if self._ring.streaming and self._exposure.governed_by(control.number):
                self._middle.changed(time.monotonic_ns(), self._exposure.read())
            if control.number in BLANKING:
                self._follow_blanking(self._controls.found())

        self._controls.guarded(change)

    def close(self) -> None:
        """Stop streaming and give the device back; a second time does nothing."""
        with self._controls.lock:
            if self._controls.closed:
                return
            self._ring.close()
            if self._uvc_clock is not None:
                self._uvc_clock.close()
            self._controls.close()
            os.close(self._fd)
            self._fd = -1

    def _call(self, number: int, argument: object) -> None:
        videodev2.ioctl(self._fd, number, argument)

    def _follow_blanking(self, known: Mapping[str, Control]) -> None:
        """Take the frame rate from a sensor's controls, where the driver tells none."""
        if self._by_blanking:
            rate = blanking_rate(self._controls.call, known, self.width, self.height)
            self.frame_rate = self.frame_rate if rate is None else rate

    # --- streaming ---

    def _next_picture(self, timeout: float) -> None:
        """Deal out the frames in the next buffer."""
        deadline = time.monotonic() + timeout
        waited = False
        spoilt_before = self.error_frames
        while True:
            buffer = self._ring.take()
            if buffer is None:
                self._ring.wait(deadline, timeout, self.error_frames - spoilt_before)
                waited = True
                continue
            try:
                # What read had to wait for is new, however slow the way from the sensor is.
                taken = (waited or not self._stale(buffer)) and self._take(buffer)
            finally:
                self._ring.give_back(buffer)
            if taken:
                return

    def _trouble(self) -> str:
        """Return ': ' and why a camera has gone quiet, or ''."""
        if self._driver == LOOPBACK:
            return (': the program that writes into this v4l2loopback device has stopped; start '
                    'it again')
        return self._signal.trouble()

    def _stale(self, buffer: videodev2.Buffer) -> bool:
        age = (time.monotonic_ns() - self._clock.monotonic(told_stamp(buffer))) / 1e9
        return 0.0 < self.longest_wait < age

    def _take(self, buffer: videodev2.Buffer) -> bool:
        """Deal out a buffer and count those lost before it; return False if it is of no use."""
        if buffer.flags & videodev2.BUF_FLAG_ERROR:
            self.error_frames += 1
            return False
        filled = self._ring.filled(buffer)
        try:
            image = self._format.picture(filled)
            quantisation = self._format.quantisation
            steps = None if quantisation is None else quantisation(filled)
        except ValueError:
            self.error_frames += 1
            return False  # cut short
        finally:
            filled.release()
        stamp_ns = self._clock.monotonic(stamp_of(buffer, self.device, time.monotonic_ns()))
        if stamp_ns < self._since_ns:
            return False
        self.sequence = self.fields.number(buffer.sequence, buffer.field)
        self._count.came(self.sequence, stamp_ns)
        self._follow_controls()
        if self._uvc_clock is not None:
            self._uvc_clock.look()
            self._middle.camera_clock(self._uvc_clock.told)
        middle_ns = self._dealer.first_field_ns(
            self._middle.middle(stamp_ns, time.monotonic_ns()), self.frame_rate)
        if self._format.saturation == FULL:
            self.saturation = self._low_bits.saturation(image)
        line_time_ns = self._line_time_ns()
        lines = image.shape[0] // self.fields.per_buffer
        later_ns = of_first_line(line_time_ns, lines, self._format.binning)
        frame = Frame(
            image, self._clock.from_monotonic(middle_ns) + later_ns, self.saturation,
            self._region.x0, self._region.y0, self._binning, self._format.layout,
            quantisation=steps, exposure_ns=self._middle.time_ns, line_time_ns=line_time_ns)
        try:
            self._dealer.deal(frame, buffer.field, self.frame_rate)
        except ValueError as error:
            raise CaptureError(
                f'{self.device}: {error}; set fields to interlaced, top or bottom') from error
        return True

    def _line_time_ns(self) -> float:
        """Return the line time of the last frame, ns; 0 where it is not known."""
        if self._given_line_time is None:
            return self._format.binning * (self._middle.line_ns or 0.0)
        return 1e9 * self._given_line_time

    def _follow_controls(self) -> None:
        """Take note of the controls that others changed, those of the exposure above all."""
        changed = self._events.take()
        self.control_changes += len(changed)
        since = [at for number, at in changed.items() if self._exposure.governed_by(number)]
        if since:
            try:
                self._middle.changed(max(since), self._exposure.read())
            except OSError as error:
                raise self._ring.lost(error) from error


def _ns(seconds: float | None) -> int | None:
    return None if seconds is None else round(seconds * 1e9)

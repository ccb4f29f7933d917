"""A V4L2 camera -> camera/image_raw and camera/camera_info."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
import sys
import threading
import time
import traceback
from typing import Any, TYPE_CHECKING

from blob_tracker.camera import CalibrationError, CameraModel, write_calibration
from blob_tracker.capture import (
    CaptureError, ControlError, Grabber, NoFrameError, V4l2Camera,
)
from blob_tracker.capture.picture import draw
from blob_tracker.nodes.interface.camera import PARAMETERS
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.losses import Losses
from blob_tracker.ros.endpoints.debug_image import DebugImage
from blob_tracker.ros.endpoints.delivery import Deliver
from blob_tracker.ros.endpoints.frame_topics import FrameTopics
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.camera_info import from_camera_model, to_camera_model
from blob_tracker.ros.parameters.controls import ControlParameters
from blob_tracker.ros.parameters.declaration import declare, on_change, undeclared
from blob_tracker.ros.parameters.given import from_files, sources
from blob_tracker.ros.parameters.url import DEFAULT_CALIBRATION_URL, to_path
from blob_tracker.ros.parameters.values import about
from blob_tracker.ros.process import run
from blob_tracker.types import Frame
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfo
from std_srvs.srv import Trigger

if TYPE_CHECKING:  # a camera by itself need not load the fits
    from blob_tracker.nodes.rehearsal import Rehearsal

# What the device is opened with: another value opens it again.
DEVICE = (
    'device', 'width', 'height', 'pixel_format', 'frame_rate', 'buffers', 'exposure_time',
    'readout_time', 'line_time', 'channel', 'fields',
)
RATE_TOLERANCE = 0.05  # of the rate that the driver grants
FRAME_TIMEOUT_S = 0.1  # s: how soon the end of the node is noticed while no frame comes
QUIET_S, LONGEST_SILENCE_S = 1.0, 10.0  # s without a frame: is told; opens the device again
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.5, 5.0  # s between attempts to open the device


class CameraNode(Node):
    """
    See the module's first line; the work is `blob_tracker.capture`'s.

    Three threads: the grabber's reads the device, one of the node's publishes the newest frame,
    and the executor's handles parameters and services. None of them waits for another's work.

    Parameters
    ----------
    deliver : callable, optional
        Takes each frame in memory, in the publishing thread; see `FrameTopics`.
    rehearsal : Rehearsal, optional
        Of who takes them, to be run in that thread before the next one comes.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(
        self,
        *,
        deliver: Deliver[tuple[Frame, CameraInfo]] | None = None,
        rehearsal: Rehearsal | None = None,
        elsewhere: Collection[str] = (),
    ) -> None:
        super().__init__('camera')
        values = declare(self, PARAMETERS, complete=False)
        self._settings: dict[str, Any] = {}
        self._sensor_size: tuple[int, int] | None = None
        self._pixel_aspect = 1.0
        # Parameters and calibration; what was made of them is beside them.
        self._in_use: tuple[dict[str, Any], CameraModel | None]
        # What they were when these camera_infos were made, by the place and binning of the frame.
        self._info_of: tuple[Any, dict[Any, CameraInfo]] = None, {}
        self._health = Health(
            self,
            'no frame arrives from the camera',
            'a longer exposure makes a camera slower, and so does automatic exposure in the dark; '
            'else look at drops and CPU',
        )
        self._connections = Connections(self, self._health)
        self._losses, self._lost = Losses(), 0
        self._rehearsal = rehearsal
        self._change(values)()
        self._controls = ControlParameters(
            self, undeclared(self, elsewhere), self._health,
            from_files(list(sources(sys.argv)), self.get_fully_qualified_name()),
        )
        on_change(self, PARAMETERS, self._change)
        self._frames = FrameTopics(self, self._health, deliver)
        self._debug_image = DebugImage(self)
        self.create_service(SetCameraInfo, 'camera/set_camera_info', self._set_camera_info)
        # In a group of its own, for the others go on while it waits for the frames.
        self.create_service(
            Trigger, 'camera/find_exposure', self._find_exposure,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )
        self._search: Future | None = None
        self._pause = FIRST_PAUSE_S
        self._awake = self.create_guard_condition(lambda: None)
        self._stop = threading.Event()
        # A daemon: an interrupt before the node is whole must not leave it running alone.
        self._thread = threading.Thread(target=self._capture, name='publish', daemon=True)
        self._thread.start()

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Read the calibration of these parameters; return what puts them into effect."""
        url = values['camera_info_url']
        with about('camera_info_url'):
            calibration = to_path(url or DEFAULT_CALIBRATION_URL, values['camera_name'])
            model = None
            if url or calibration.exists():
                model = CameraModel.from_file(calibration, warn=self.get_logger().warning)
        device = {name: values[name] for name in DEVICE}
        for name in ('exposure_time', 'readout_time'):
            device[name] = device[name] or None
        if values['rolling_shutter'] and not device['line_time']:
            device['line_time'] = None  # as the device tells
        if model is not None and device == self._settings:
            with about('camera_info_url'):
                self._check_size(model)

        def use() -> None:
            self._calibration = calibration
            self._in_use = values, model
            # The thread that captures opens the device again where this is another one.
            if self._settings != device:
                self._settings = device

        return use

    def destroy_node(self) -> None:
        """End the capture, which frees the device, and then the node."""
        self._stop.set()
        self._thread.join()
        super().destroy_node()

    def _capture(self) -> None:
        """Stream until the node ends; open the device again whenever it fails."""
        while not self._stop.is_set():
            settings = self._opened_with = self._settings
            try:
                with (
                    V4l2Camera(**settings, prepare=self._controls.prepare) as camera,
                    Grabber(camera) as grabber,
                ):
                    self._sensor_size = camera.sensor_size
                    self._controls.attach(camera)
                    self._stream(camera, grabber)
                self._controls.detach()
            except ParameterError:
                return  # the executor ends the node with it
            except (CaptureError, CalibrationError) as error:
                self._wait(str(error))  # not at all where it was closed for other settings
            except Exception as error:  # a thread that ended here would leave a silent node
                if not rclpy.ok():
                    return  # a signal ended the context meanwhile
                self.get_logger().error(traceback.format_exc(), throttle_duration_sec=60.0)
                self._wait(
                    f'the capture failed with {type(error).__name__}: {error}; the device is '
                    'opened again; if that does not help report it with the log'
                )

    def _wait(self, why: str) -> None:
        """Say why there are no frames until it is time to open the device again."""
        self._controls.detach()
        again = time.monotonic() + self._pause
        while time.monotonic() < again and not self._ends:
            self._health.fault(ERROR, why)  # it holds until it is gone
            self._answer(False, why)
            self._stop.wait(FIRST_PAUSE_S)
        self._pause = min(2.0 * self._pause, LONGEST_PAUSE_S)

    @property
    def _ends(self) -> bool:
        """Tell whether the node ends, or the device is to be opened with other settings."""
        return self._stop.is_set() or self._settings is not self._opened_with

    def _stream(self, camera: V4l2Camera, grabber: Grabber) -> None:
        """Publish the newest frame until the settings change; search the exposure when asked."""
        rate = f'{camera.frame_rate:g} Hz' if camera.frame_rate else 'an unknown rate'
        self.get_logger().info(
            f'streaming {camera.width} x {camera.height} px at {rate} '
            f'from {camera.device}; fields: {camera.fields}; stamps: {camera.stamp_place}; '
            f'{camera.pixel_format} clips at {camera.saturation} DN: saturation of segmenter and '
            'locator'
        )
        self._pixel_aspect = camera.pixel_aspect
        self._info_of = None, {}
        self._lost = 0
        while not self._ends:
            self._publish_next(camera, grabber)
            if self._search is None:
                continue
            try:
                outcome = self._controls.adjust_exposure(
                    camera, lambda: self._publish_next(camera, grabber),
                    self._in_use[0]['channel'],
                )
                self._answer(outcome.found, outcome.words)
            except ControlError as error:
                self._answer(False, str(error))

    def _publish_next(self, camera: V4l2Camera, grabber: Grabber) -> Frame:
        """Publish the next frame with its camera_info, and return it."""
        frame = self._next(camera, grabber)
        # Parameters and set_camera_info may change both at any time.
        in_use = values, model = self._in_use
        if self._info_of[0] is not in_use:
            self._info_of = in_use, {}
        infos, kind = self._info_of[1], (frame.y0, frame.binning)
        if kind not in infos:
            infos[kind] = self._make_info(model, values['field_of_view'], frame)
        info = infos[kind]
        self._health.arrived(frame.stamp_ns)
        self._frames.publish(frame, info, values['frame_id'])
        self._health.left(frame.stamp_ns)
        self._pause = FIRST_PAUSE_S  # not before: a device may open well and fail at once
        self._report(camera, grabber, bool(info.k[0]))
        self._debug_image.offer(
            lambda: draw(frame, self._in_words(camera, grabber)),
            frame.stamp_ns,
            values['frame_id'],
        )
        return frame

    def _next(self, camera: V4l2Camera, grabber: Grabber) -> Frame:
        """
        Return the next frame, whenever it comes.

        Raises
        ------
        CaptureError
            There will be none: the device fails, is silent for too long, or is to be closed.

        """
        begin = time.monotonic()
        while not self._ends:
            rehearsal = self._rehearsal
            pause = FRAME_TIMEOUT_S if rehearsal is None else rehearsal.pause()
            try:
                return grabber.newest(min(pause, FRAME_TIMEOUT_S))
            except NoFrameError as error:
                if rehearsal is not None and pause < FRAME_TIMEOUT_S:
                    rehearsal.run()
                    continue
                self._show_losses(camera, grabber)  # spoilt pictures alone may be all that comes
                # A slow or triggered camera is no broken one: only a long silence opens it anew.
                silence = time.monotonic() - begin
                if silence > LONGEST_SILENCE_S:
                    raise
                if silence > QUIET_S:
                    self._health.fault(ERROR, str(error))
        raise CaptureError('the device is closed, as its settings changed')

    def _make_info(
        self, model: CameraModel | None, field_of_view: float, frame: Frame
    ) -> CameraInfo:
        """Return the camera_info of frames such as this one."""
        assert self._sensor_size is not None
        if model is None and field_of_view > 0.0:
            model = CameraModel.from_field_of_view(
                *self._sensor_size, field_of_view, self._pixel_aspect
            )
        height, width = frame.image.shape[:2]
        return from_camera_model(
            model, width, height, x0=frame.x0, y0=frame.y0, binning=frame.binning,
            sensor_size=self._sensor_size,
        )

    def _report(self, camera: V4l2Camera, grabber: Grabber, calibrated: bool) -> None:
        """Tell the diagnostics of a frame."""
        self._health.count('frames')
        self._show_losses(camera, grabber)
        self._watch_losses(camera, grabber)
        if camera.sensor:
            self._health.show('sensor', camera.sensor)
        self._health.show('exposure time', _exposure(camera))
        self._health.show('stamp', camera.stamp_place)
        self._health.show('fields', str(camera.fields))
        self._health.show('line time', _line_time(camera, self._settings['line_time']))
        if camera.line_time is None:
            self._health.fault(
                WARN,
                'rolling_shutter is on, and the device has no controls hblank and pixel_rate to '
                'give its line time: the stamps are those of the first line; measure it with '
                'python3 -m blob_tracker calibrate line_time, and set line_time',
            )
        self._health.show('saturation', camera.saturation)
        if not calibrated:
            self._health.fault(
                WARN,
                f'the camera is not calibrated: there is no {self._calibration}, K is 0 and '
                'there will be no bearing; calibrate it or set field_of_view',
            )
        rate = self._in_use[0]['frame_rate']
        # Nobody notices 29.97 for 30; where the driver does not tell its rate it is 0.
        if rate > 0.0 and camera.frame_rate > 0.0 and abs(camera.frame_rate / rate - 1.0) > 0.01:
            self._health.fault(
                WARN,
                f'frame_rate is {rate:g} Hz and the driver gives {camera.frame_rate:g} Hz; set '
                'one that the camera offers at this size and pixel_format (see v4l2-ctl '
                '--list-formats-ext)',
            )
        self._compare_rate(camera, rate or camera.frame_rate)
        for warning in self._controls.warnings:
            self._health.fault(WARN, warning)
        self._health.ok('streaming')

    def _compare_rate(self, camera: V4l2Camera, promised: float) -> None:
        """Warn where frames come at another rate than the driver grants."""
        measured = camera.measured_rate
        if measured and promised and abs(measured / promised - 1.0) > RATE_TOLERANCE:
            self._health.fault(
                WARN,
                f'frames come at {measured:.4g} Hz by their stamps, and {promised:.4g} Hz were '
                'granted: a long exposure slows a camera down, and a trigger or the program that '
                'writes into v4l2loopback has its own rate; shorten the exposure, or set '
                'frame_rate to the rate that comes',
            )

    def _show_losses(self, camera: V4l2Camera, grabber: Grabber) -> None:
        self._health.show('drops', camera.drops)
        self._health.show('overruns', grabber.overruns)
        self._health.show('error frames', camera.error_frames)

    def _watch_losses(self, camera: V4l2Camera, grabber: Grabber) -> None:
        """Warn where a part of the frames does not come through."""
        lost = camera.drops + grabber.overruns
        self._losses.add(lost - self._lost)
        self._lost = lost
        if self._losses.grave:
            self._health.fault(
                WARN,
                f'{100.0 * self._losses.share:.0f} % of the last frames were lost: the driver '
                f'dropped {camera.drops} (raise buffers, or give the camera its own port), this '
                f'process was too late for {grabber.overruns} (see CPU; lower frame_rate, width '
                'and height)',
            )

    def _in_words(self, camera: V4l2Camera, grabber: Grabber) -> list[str]:
        """Return rate, exposure and losses in lines of text."""
        return [
            f'{camera.width} x {camera.height} px, {self._health.rate:.2f} Hz of '
            f'{camera.frame_rate:g}, exposure {_exposure(camera)}',
            f'{camera.drops} drops, {grabber.overruns} overruns, {camera.error_frames} error '
            'frames',
        ]

    def _check_size(self, model: CameraModel) -> None:
        """Refuse the calibration of another camera than the one that is open."""
        if self._sensor_size not in (None, (model.width, model.height)):
            raise MessageError(
                f'camera_info: the calibration is for {model.width} x {model.height} px and '
                'the sensor has {} x {} px; calibrate that size'.format(*self._sensor_size)
            )

    def _set_camera_info(
        self, request: SetCameraInfo.Request, response: SetCameraInfo.Response
    ) -> SetCameraInfo.Response:
        """Take a calibration, store it and use it from the next frame on."""
        try:
            model = replace(
                to_camera_model(request.camera_info), name=self._in_use[0]['camera_name']
            )
            self._check_size(model)
            write_calibration(self._calibration, model)
        except (MessageError, CalibrationError) as error:
            response.status_message = str(error)
            url = self._in_use[0]['camera_info_url']
            if url.startswith('package://') and isinstance(error, CalibrationError):
                response.status_message += '; set camera_info_url to a file:// that you may write'
            return response
        self._in_use = self._in_use[0], model
        response.success = True
        response.status_message = f'stored in {self._calibration} and in use'
        self.get_logger().info(f'calibration {response.status_message}')
        return response

    async def _find_exposure(
        self, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """Have the publishing thread search for the exposure; wait for it without blocking."""
        self._search = Future()
        response.success, response.message = await self._search
        self.get_logger().info(f'find_exposure: {response.message}')
        return response

    def _answer(self, found: bool, words: str) -> None:
        """Give the outcome of a search to whoever asked for one, if anybody did."""
        search, self._search = self._search, None
        if search is not None:
            search.set_result((found, words))
            self._awake.trigger()


def _exposure(camera: V4l2Camera) -> str:
    seconds = camera.exposure_time
    return 'unknown' if seconds is None else f'{1e3 * seconds:.4g} ms'


def _line_time(camera: V4l2Camera, asked: float | None) -> str:
    """Say which line time is used, and where it is from."""
    if camera.line_time is None:
        return 'unknown, taken as 0'
    read = camera.read_time
    if asked is None:
        return f'{1e6 * camera.line_time:.4f} us, by hblank and pixel_rate of the device'
    if asked:
        return f'{1e6 * asked:.4f} us, as line_time is set'
    told = '' if read is None else (
        f'; the device reads a line in {1e6 * read:.4f} us: set rolling_shutter if it has one'
    )
    return f'0, a global shutter{told}'


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [CameraNode()]))

"""target/window -> target/bearing, target/centroid and target/ray."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from inspect import signature
import sys
from threading import Lock
from typing import Any

from blob_tracker.camera import CalibrationError, CameraModel, LensError
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.location import compile_ahead, locate, METHODS
from blob_tracker.location.noise import variance_ratio
from blob_tracker.ros.bearing_topics import BearingTopics
from blob_tracker.ros.camera_info import to_camera_model
from blob_tracker.ros.clipping import clipping_window
from blob_tracker.ros.clock_jumps import on_clock_jump
from blob_tracker.ros.connections import Connections
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.health import ERROR, Health, WARN
from blob_tracker.ros.image import to_window
from blob_tracker.ros.names import target_topic
from blob_tracker.ros.pairing import FramePairs
from blob_tracker.ros.parameters import declare, on_change, Parameter
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import STATE, subscription
from blob_tracker.ros.target import to_noise
from blob_tracker.ros.url import to_path
from blob_tracker.types import Location, LocationError, SensorNoise, Window
from geometry_msgs.msg import Vector3Stamped
import numpy as np
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import CameraInfo, Image

DEFAULT_METHOD = 'maximum_likelihood'
PARAMETERS = (
    Parameter(
        'method',
        DEFAULT_METHOD,
        'How the blob is placed in its window. The default is at the limit that the noise sets; '
        'the others are those of the thesis.',
        choices=tuple(METHODS),
    ),
    Parameter(
        'elliptical',
        False,
        'Fit a width along x and one along y, for a lens or a light that does not make round '
        'blobs. For the methods that have both forms.',
    ),
    Parameter(
        'noise.gain',
        40.0,
        'Electrons per DN of the camera: the slope of its photon transfer curve. It sets the '
        'shot noise in the covariance.',
        least=1e-3,
        most=1e6,
        unit='e-/DN',
    ),
    Parameter(
        'noise.read_noise',
        0.7,
        'Standard deviation of a dark pixel before quantisation. It sets the covariance of faint '
        'targets.',
        least=0.0,
        most=1e4,
        unit='DN',
    ),
    Parameter(
        'noise.black_level',
        0.0,
        'Mean of a pixel without light, the pedestal: there is no shot noise in it.',
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'noise.online',
        False,
        'Take all three from target/noise, where the segmenter measures them (noise.measure), as '
        'soon as they arrive. Off, a bag gives the same numbers each time.',
    ),
    Parameter(
        'looks',
        1,
        'Frames that are summed in a window, as the segmenter says in its diagnostics: their read '
        'noise is in the covariance as often.',
        least=1,
        most=256,
    ),
    Parameter(
        'saturation',
        0,
        'Level at which a pixel is clipped; 0 is full scale of the encoding. Set 4095 for 12 bits '
        'in 16.',
        least=0,
        most=65535,
        unit='DN',
    ),
    Parameter(
        'line_jitter_url',
        '',
        'Line offsets of an analogue grabber, as `calibrate jitter` writes them, to be taken off '
        'each location: path, file:// or package://. Empty for a digital camera.',
    ),
    Parameter(
        'lights',
        '',
        'Names of the coded lights that are to be placed, as flash.codes has them: '
        'port,starboard. Empty for a light without a name. Within the pipeline every light is.',
    ),
)
DIFFERENT = 1.5  # ratio of two variances; what is measured has sigmas far below that


class LocatorNode(Node):
    """
    See the module's first line; the work is that of the rooms `location` and `camera`.

    Parameters
    ----------
    listen : bool
        Whether windows come from target/window/...; else whoever has them calls `locate`.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(self, *, listen: bool = True, elsewhere: Collection[str] = ()) -> None:
        super().__init__('locator')
        values = declare(self, PARAMETERS, elsewhere)
        self._listen = listen
        self._lock = Lock()  # windows may come from a thread of the camera's
        self._health = Health(self, 'no window arrives; is the segmenter running?')
        self._connections = Connections(self, self._health)
        self._calibration: tuple[object, ...] = ()
        self._camera_model: CameraModel | None = None
        self._targets: dict[str, BearingTopics] = {}
        self._windows: dict[str, FramePairs] = {}
        self._measurements: Subscription | None = None
        self._change(values)()
        on_change(self, PARAMETERS, self._change)
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build what these parameters ask for; return what puts it into effect."""
        method = values['method']
        options = {}
        if values['elliptical']:
            if 'elliptical' not in signature(METHODS[method]).parameters:
                raise ParameterError(
                    f"parameter 'elliptical' is True; the method '{method}' has no such form"
                )
            options['elliptical'] = True
        compile_ahead([method])
        noise = SensorNoise(
            values['noise.gain'], values['noise.read_noise'], values['noise.black_level']
        )
        line_jitter = _line_jitter(values['line_jitter_url'])
        lights = values['lights'].replace(' ', '').split(',')  # [''] where it is empty
        for light in lights:
            if lights != [''] and not (light.isidentifier() and light.isascii()):
                raise ParameterError(
                    f"parameter 'lights': '{light}' is no name of a light; they are separated by "
                    'commas, as in port,starboard'
                )

        def use() -> None:
            with self._lock:
                self._method, self._options = method, options
                self._saturation, self._looks = values['saturation'], values['looks']
                self._configured = self._noise = noise
                self._line_jitter = line_jitter
                self._set_lights(lights)
                self._set_online(values['noise.online'])

        return use

    def _set_lights(self, lights: Collection[str]) -> None:
        """Listen to the windows of these lights, and of no other."""
        if not self._listen:
            return
        for name in [name for name in self._targets if name not in lights]:
            self._windows.pop(name).close()
            self._targets.pop(name).close()
        for name in lights:
            if name not in self._targets:
                self._targets[name] = BearingTopics(self, target_topic(name))
                self._windows[name] = FramePairs(
                    self, f'{target_topic(name)}/window', self._health, partial(self._take, name)
                )

    def _set_online(self, online: bool) -> None:
        """Listen to the noise that the segmenter measures, or no longer."""
        if not online:
            if self._measurements is not None:
                self.destroy_subscription(self._measurements)
                self._measurements = None
            self._health.show('noise', f'as configured: {_in_words(self._configured)}')
        elif self._measurements is None:
            self._health.show('noise', 'as configured: none has been measured yet')
            self._measurements = subscription(
                self, Vector3Stamped, 'target/noise', self._measured, STATE
            )

    def _measured(self, message: Vector3Stamped) -> None:
        """Take the noise that the segmenter measured."""
        try:
            noise = to_noise(message)
        except MessageError as error:
            self._health.fault(ERROR, f'target/noise: {error}')
            return
        with self._lock:
            self._noise = noise
        self._health.show('noise', f'as measured: {_in_words(noise)}')

    def _take(self, light: str, image: Image, info: CameraInfo) -> None:
        """Take a window from the topics."""
        try:
            window = to_window(image, info)
        except MessageError as error:
            self._health.fault(ERROR, f'{target_topic(light)}/window: {error}')
            return
        self.locate(light, window, info, image.header.frame_id)

    def _forget(self, after_ns: int) -> None:
        """Forget the windows that wait for their camera_info and have a later stamp, ns."""
        for windows in self._windows.values():
            windows.forget(after_ns)

    def locate(self, light: str, window: Window, info: CameraInfo, frame_id: str) -> None:
        """Place the blob of a window and publish its direction, or nothing at all."""
        with self._lock:
            if light not in self._targets:  # handed over in memory
                self._targets[light] = BearingTopics(self, target_topic(light))
            self._locate(light, window, info, frame_id)

    def _locate(self, light: str, window: Window, info: CameraInfo, frame_id: str) -> None:
        try:
            camera_model = self._model(info)
            window = clipping_window(window, self._saturation, self._looks)
            location = locate(window, method=self._method, noise=self._noise, **self._options)
            if self._line_jitter is not None:
                self._line_jitter.check_height(camera_model.height)
                location = self._line_jitter.corrected(
                    location, gain=self._noise.gain, looks=self._looks
                )
            bearing = camera_model.bearing(location)
        except MessageError as error:
            self._health.fault(ERROR, f'{target_topic(light)}/window: {error}')
            return
        except CalibrationError as error:
            self._health.fault(ERROR, f'line_jitter_url: {error}')
            return
        except (LocationError, LensError) as error:
            self._health.fault(WARN, f'target not located: {error}')
            return
        self._targets[light].publish(bearing, location, frame_id)
        self._health.count('bearings')
        self._health.show('snr', f'{location.snr:.1f}')
        self._health.show('saturated pixels', location.saturated)
        self._health.ok('target located')
        self._compare_noise(location)

    def _compare_noise(self, location: Location) -> None:
        """Warn where the configured noise is not the measured one at the target's levels."""
        if self._noise is self._configured:
            return
        levels = np.array([location.background, location.background + location.amplitude])
        ratio = variance_ratio(levels / self._looks, self._configured, self._noise)
        if not 1.0 / DIFFERENT <= ratio <= DIFFERENT:
            self._health.fault(
                WARN,
                f'the configured noise ({_in_words(self._configured)}) has {ratio:.2g} times the '
                f'variance of the measured one, which is used; set noise.gain, '
                f'noise.read_noise and noise.black_level to {_in_words(self._noise)}',
            )

    def _model(self, info: CameraInfo) -> CameraModel:
        """Return the camera of a camera_info, made anew only where the calibration changes."""
        calibration = (*info.k, *info.d, info.distortion_model, info.width, info.height)
        # NaN differs from itself: such a calibration is never the last one, and is refused again.
        if self._camera_model is None or calibration != self._calibration:
            self._camera_model = None
            self._camera_model = to_camera_model(info)
            self._calibration = calibration
        return self._camera_model


def _line_jitter(url: str) -> LineJitter | None:
    """Return the line jitter of the parameter; None where it is empty."""
    if not url:
        return None
    try:
        return LineJitter.from_yaml(to_path(url))
    except (CalibrationError, ParameterError) as error:
        raise ParameterError(f"parameter 'line_jitter_url': {error}") from None


def _in_words(noise: SensorNoise) -> str:
    return f'{noise.gain:.4g} e-/DN, {noise.read_noise:.3g} DN, {noise.black_level:.4g} DN'


def compile_default() -> None:
    """Compile the fits, before the first target could wait for them."""
    print('loading the fits; the first start compiles them for 10 s or so', file=sys.stderr)
    compile_ahead([DEFAULT_METHOD])


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [LocatorNode()], compile_default))

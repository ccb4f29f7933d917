"""target/window -> target/bearing, target/centroid and target/ray."""

from __future__ import annotations

from inspect import signature
import sys

from blob_tracker.camera import CalibrationError, CameraModel, LensError
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.location import compile_ahead, locate, METHODS
from blob_tracker.location.noise import variance_ratio
from blob_tracker.ros.camera_info import to_camera_model
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.health import ERROR, Health, WARN
from blob_tracker.ros.image import to_window
from blob_tracker.ros.pairing import subscribe
from blob_tracker.ros.parameters import declare, Parameter
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import overridable, RESULT, STATE
from blob_tracker.ros.target import (
    bearing_message,
    centroid_message,
    ray_message,
    to_noise,
)
from blob_tracker.ros.url import to_path
from blob_tracker.types import Location, LocationError, SensorNoise
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from rclpy.node import Node
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
)


DIFFERENT = 1.5  # ratio of two variances; what is measured has sigmas far below that


class LocatorNode(Node):
    """See the module's first line; the work is that of the rooms `location` and `camera`."""

    def __init__(self) -> None:
        super().__init__('locator')
        settings = declare(self, PARAMETERS)
        self._method = settings['method']
        self._options = {}
        if settings['elliptical']:
            if 'elliptical' not in signature(METHODS[self._method]).parameters:
                raise ParameterError(
                    f"parameter 'elliptical' is True; the method '{self._method}' has no such form"
                )
            self._options['elliptical'] = True
        compile_ahead([self._method])
        self._saturation = settings['saturation']
        self._looks = settings['looks']
        self._noise = SensorNoise(
            settings['noise.gain'], settings['noise.read_noise'], settings['noise.black_level']
        )
        self._configured = self._noise
        self._line_jitter = _line_jitter(settings['line_jitter_url'])
        self._health = Health(self, 'no window arrives; is the segmenter running?')
        self._calibration: tuple[object, ...] = ()
        self._camera_model: CameraModel | None = None
        self._bearings, self._centroids, self._rays = (
            self.create_publisher(kind, name, RESULT, qos_overriding_options=overridable())
            for kind, name in (
                (Vector3Stamped, 'target/bearing'),
                (PointStamped, 'target/centroid'),
                (PoseWithCovarianceStamped, 'target/ray'),
            )
        )
        if settings['noise.online']:
            self._health.show('noise', 'as configured: none has been measured yet')
            self.create_subscription(
                Vector3Stamped,
                'target/noise',
                self._measured,
                STATE,
                qos_overriding_options=overridable(),
            )
        subscribe(self, 'target/window', self._health, self._locate)

    def _measured(self, message: Vector3Stamped) -> None:
        """Take the noise that the segmenter measured."""
        try:
            self._noise = to_noise(message)
        except MessageError as error:
            self._health.fault(ERROR, f'target/noise: {error}')
            return
        self._health.show('noise', f'as measured: {_in_words(self._noise)}')

    def _locate(self, image: Image, info: CameraInfo) -> None:
        """Place the blob of a window and publish its direction, or nothing at all."""
        try:
            camera_model = self._model(info)
            window = to_window(image, info, self._saturation, self._looks)
            location = locate(
                window, method=self._method, noise=self._noise, **self._options
            )
            if self._line_jitter is not None:
                self._line_jitter.check_height(camera_model.height)
                location = self._line_jitter.corrected(
                    location, gain=self._noise.gain, looks=self._looks
                )
            bearing = camera_model.bearing(location)
        except MessageError as error:
            self._health.fault(ERROR, f'target/window: {error}')
            return
        except CalibrationError as error:
            self._health.fault(ERROR, f'line_jitter_url: {error}')
            return
        except (LocationError, LensError) as error:
            self._health.fault(WARN, f'target not located: {error}')
            return
        frame_id = image.header.frame_id
        self._bearings.publish(bearing_message(bearing, frame_id))
        self._centroids.publish(centroid_message(location, frame_id))
        self._rays.publish(ray_message(bearing, frame_id))
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
    sys.exit(run(LocatorNode, compile_default))

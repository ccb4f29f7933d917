"""A V4L2 camera -> camera/image_raw and camera/camera_info."""

from __future__ import annotations

import sys
import threading
import time

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.capture import CaptureError, NoFrameError, PIXEL_FORMATS, V4l2Camera
from blob_tracker.ros.camera_info import from_camera_model, stamped
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.health import ERROR, Health, WARN
from blob_tracker.ros.image import from_pixels
from blob_tracker.ros.parameters import declare, Parameter
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import IMAGE_OUT, overridable
from blob_tracker.ros.url import to_path
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

PARAMETERS = (
    Parameter('device', '/dev/video0', 'The camera: its path, or a link in /dev/v4l/by-id.'),
    Parameter(
        'width', 0, 'Width of the frames; 0 leaves the driver its own.', 0, 16384, unit='px'
    ),
    Parameter(
        'height', 0, 'Height of the frames; 0 leaves the driver its own.', 0, 16384, unit='px'
    ),
    Parameter(
        'pixel_format',
        '',
        'FourCC of the pixels; empty takes the first of these that the camera offers.',
        choices=('', *PIXEL_FORMATS),
    ),
    Parameter(
        'frame_rate',
        0.0,
        'Frames a second; 0 leaves the driver its own.',
        least=0.0,
        most=10000.0,
        unit='Hz',
    ),
    Parameter(
        'buffers',
        4,
        'Buffers in the driver: more of them ride out longer pauses of this machine.',
        least=2,
        most=32,
    ),
    Parameter('frame_id', 'camera_optical_frame', 'Name of the optical frame.'),
    Parameter(
        'camera_info_url',
        '',
        'Calibration: a path, file:// or package:// URL. Without one, and without field_of_view, '
        'K is 0 and no bearing can be computed.',
    ),
    Parameter(
        'field_of_view',
        0.0,
        'Horizontal field of view of the lens by its data sheet, for a camera that is not yet '
        'calibrated; 0 is unknown. Angles made with it are as good as the data sheet.',
        least=0.0,
        most=170.0,
        unit='degrees',
    ),
)
READ_TIMEOUT = 0.5  # s: the longest that the end of the node waits for the capture thread
LONGEST_SILENCE = 10.0  # s without a frame after which the device is opened again
FIRST_PAUSE, LONGEST_PAUSE = 0.5, 5.0  # s between attempts to open the device


class CameraNode(Node):
    """See the module's first line; the work is `blob_tracker.capture.v4l2.V4l2Camera`'s."""

    def __init__(self) -> None:
        super().__init__('camera')
        settings = declare(self, PARAMETERS)
        self._frame_id = settings.pop('frame_id')
        self._field_of_view = settings.pop('field_of_view')
        url = settings.pop('camera_info_url')
        try:
            self._camera_model = CameraModel.from_yaml(to_path(url)) if url else None
        except (CalibrationError, ValueError) as error:
            raise ParameterError(f"parameter 'camera_info_url': {error}") from None
        self._settings = settings
        self._health = Health(self, 'no frame arrives from the camera')
        self._images = self.create_publisher(
            Image, 'camera/image_raw', IMAGE_OUT, qos_overriding_options=overridable()
        )
        self._infos = self.create_publisher(
            CameraInfo, 'camera/camera_info', IMAGE_OUT, qos_overriding_options=overridable()
        )
        self._stop = threading.Event()
        # A daemon: an interrupt before the node is whole must not leave it running alone.
        self._thread = threading.Thread(target=self._capture, name='capture', daemon=True)
        self._thread.start()

    def destroy_node(self) -> None:
        """End the capture thread, which frees the device, and then the node."""
        self._stop.set()
        self._thread.join()
        super().destroy_node()

    def _capture(self) -> None:
        """Stream until the node ends; open the device again whenever it fails."""
        pause = FIRST_PAUSE
        while not self._stop.is_set():
            try:
                with V4l2Camera(**self._settings) as camera:
                    pause = FIRST_PAUSE
                    self._stream(camera)
            except (CaptureError, CalibrationError) as error:
                again = time.monotonic() + pause
                while time.monotonic() < again and not self._stop.is_set():
                    self._health.fault(ERROR, str(error))  # it holds until it is gone
                    self._stop.wait(FIRST_PAUSE)
                pause = min(2.0 * pause, LONGEST_PAUSE)
            except RuntimeError:  # of rclpy's C layer: a signal ended the context meanwhile
                if rclpy.ok():
                    raise
                return

    def _stream(self, camera: V4l2Camera) -> None:
        """Publish each frame with its camera_info."""
        model = self._camera_model
        if model is None and self._field_of_view > 0.0:
            model = CameraModel.from_field_of_view(
                camera.width, camera.height, self._field_of_view
            )
        info = from_camera_model(model, camera.width, camera.height)
        image = Image()
        self.get_logger().info(
            f'streaming {camera.width} x {camera.height} px at {camera.frame_rate:g} Hz '
            f'from {self._settings["device"]}'
        )
        silence = 0.0
        while not self._stop.is_set():
            try:
                frame = camera.read(timeout=READ_TIMEOUT)
            except NoFrameError as error:
                # A slow or triggered camera is no broken one: only a long silence opens it anew.
                silence += READ_TIMEOUT
                if silence > LONGEST_SILENCE:
                    raise
                if silence > 1.0:
                    self._health.fault(ERROR, str(error))
                continue
            silence = 0.0
            self._images.publish(from_pixels(frame.image, frame.stamp_ns, self._frame_id, image))
            self._infos.publish(stamped(info, frame.stamp_ns, self._frame_id))
            self._health.count('frames')
            self._health.show('drops', camera.drops)
            if model is None:
                self._health.fault(
                    WARN,
                    'the camera is not calibrated: K is 0 and there will be no bearing; '
                    'set camera_info_url',
                )
            self._health.ok('streaming')


def main() -> None:
    """Run the node."""
    sys.exit(run(CameraNode))

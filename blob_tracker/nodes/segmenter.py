"""camera/image_raw -> target/window: find the flash and cut it out, lit and unlit."""

from __future__ import annotations

import sys

from blob_tracker.ros.camera_info import of_window
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.health import ERROR, Health, WARN
from blob_tracker.ros.image import from_window, to_frame
from blob_tracker.ros.pairing import subscribe
from blob_tracker.ros.parameters import declare, Parameter
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import IMAGE_OUT, overridable, STATE
from blob_tracker.segmentation import FrameError, Segmenter
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool

PARAMETERS = (
    Parameter(
        'min_snr',
        7.0,
        'Least rise of the brightest pixel from the unlit to the lit frame, in standard '
        'deviations of the difference. Below 6 the noise of a whole frame reaches it by itself.',
        least=3.0,
        most=1000.0,
    ),
    Parameter(
        'max_pair_interval',
        0.1,
        'Greatest time between the lit and the unlit frame. Raise it for cameras below 10 Hz, '
        'lower it where the camera moves fast.',
        least=0.001,
        most=10.0,
        unit='s',
    ),
    Parameter(
        'window_scale',
        2.0,
        'Width of the window in widths of the thresholded blob. The location wants the tails '
        'that the threshold leaves outside; too wide a window adds noise.',
        least=1.0,
        most=10.0,
    ),
    Parameter(
        'max_blob',
        64,
        'Half-width up to which the window grows in search of its threshold; what is wider is '
        'no target.',
        least=4,
        most=1024,
        unit='px',
    ),
    Parameter(
        'lost_after',
        0.2,
        'Time without a target, by the stamps, after which target/visible turns false.',
        least=0.001,
        most=60.0,
        unit='s',
    ),
)
CHECK = 0.25  # s between two looks at whether frames still come
SILENCE = 1.0  # s of wall time without a good frame; slow bags and cameras pause for less


class SegmenterNode(Node):
    """See the module's first line; the work is `blob_tracker.segmentation.Segmenter`'s."""

    def __init__(self) -> None:
        super().__init__('segmenter')
        settings = declare(self, PARAMETERS)
        self._lost_after_ns = int(1e9 * settings.pop('lost_after'))
        self._segmenter = Segmenter(**settings)
        self._health = Health(
            self, 'no frames arrive; is a camera publishing camera/image_raw and camera_info?'
        )
        self._windows, self._infos, self._visible = (
            self.create_publisher(kind, name, qos, qos_overriding_options=overridable())
            for kind, name, qos in (
                (Image, 'target/window/image_raw', IMAGE_OUT),
                (CameraInfo, 'target/window/camera_info', IMAGE_OUT),
                (Bool, 'target/visible', STATE),
            )
        )
        self._seen_ns: int | None = None
        self._said_visible: bool | None = None
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._good_frame = self._steady.now()
        subscribe(self, 'camera', self._health, self._segment)
        self.create_timer(CHECK, self._check_silence, clock=self._steady)

    def _segment(self, image: Image, info: CameraInfo) -> None:
        """Compare a frame with the one before it; publish the target's window if there is one."""
        try:
            frame = to_frame(image, info)
            window = self._segmenter.update(frame)
        except MessageError as error:
            self._health.fault(ERROR, f'camera/image_raw: {error}')
            return
        except FrameError as error:
            self._health.fault(WARN, f'camera/image_raw: {error}')
            return
        self._health.count('frames')
        if window is not None:
            self._health.count('windows')
            # The window is sent first: its receiver works while the camera_info is on the way.
            self._windows.publish(from_window(window, image.header.frame_id))
            self._infos.publish(of_window(info, window))
            self._seen_ns = frame.stamp_ns
            self._health.ok('target in view')
        else:
            self._health.show('last frame without target', self._segmenter.reason)
        self._good_frame = self._steady.now()
        visible = self._seen_ns is not None and 0 <= (
            frame.stamp_ns - self._seen_ns
        ) <= self._lost_after_ns
        if not visible:
            self._health.ok(f'no target: {self._segmenter.reason}')
        self._say_visible(visible)

    def _check_silence(self) -> None:
        """Say that the target is out of view when no good frame has come for a while."""
        if (self._steady.now() - self._good_frame).nanoseconds > 1e9 * SILENCE:
            self._say_visible(False)

    def _say_visible(self, visible: bool) -> None:
        """Publish on change."""
        if visible is not self._said_visible:
            self._visible.publish(Bool(data=visible))
            self._said_visible = visible


def main() -> None:
    """Run the node."""
    sys.exit(run(SegmenterNode))

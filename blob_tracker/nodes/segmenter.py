"""camera/image_raw -> target/window: find the flash and cut it out, lit and unlit."""

from __future__ import annotations

import sys

from blob_tracker.ros.camera_info import of_window, stamped
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.health import ERROR, Health, WARN
from blob_tracker.ros.image import from_window, to_frame
from blob_tracker.ros.pairing import subscribe
from blob_tracker.ros.parameters import declare, Parameter
from blob_tracker.ros.process import run
from blob_tracker.ros.qos import IMAGE_OUT, overridable, STATE
from blob_tracker.segmentation import (
    codes_from_text,
    compile_ahead,
    flash_by_name,
    FLASH_MODES,
    FrameError,
    REGISTRATIONS,
    Segmenter,
    threshold_by_name,
    THRESHOLDS,
)
from blob_tracker.types import Window
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool

PARAMETERS = (
    Parameter(
        'flash.mode',
        'alternate',
        'How the light flashes. alternate: in step with the camera, on in every other frame. '
        'periodic: free-running at flash.frequency. coded: lights that blink flash.codes. '
        'steady: always on.',
        choices=tuple(FLASH_MODES),
    ),
    Parameter(
        'flash.frequency',
        15.0,
        'Of a periodic light; from 0.1 to 0.45 of the frame rate.',
        least=0.01,
        most=500.0,
        unit='Hz',
    ),
    Parameter(
        'flash.duty',
        0.5,
        'Part of its period in which a periodic light is on.',
        least=0.05,
        most=0.95,
    ),
    Parameter(
        'flash.frames',
        16,
        'Frames over which a periodic light is demodulated: more find a fainter light and give '
        'fewer windows. It must stand still meanwhile.',
        least=4,
        most=256,
    ),
    Parameter(
        'flash.codes',
        '',
        'Bits of the coded lights, all of one length: port:1101000,starboard:1110100. Each has '
        'topics of its own, target/port/...',
    ),
    Parameter(
        'flash.frames_per_bit',
        1,
        'Frames in which a coded light holds each bit.',
        least=1,
        most=64,
    ),
    Parameter(
        'flash.bit_errors',
        0,
        'Bits of a code that may be wrong. Any two codes must differ by more than twice as many.',
        least=0,
        most=8,
    ),
    Parameter(
        'min_snr',
        8.0,
        'Least SNR of the target: of its matched filter in the mode alternate, of its brightest '
        'pixel or amplitude in the others. Below 6 the noise of a whole frame reaches it by '
        'itself.',
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
        'registration',
        'none',
        'How the unlit frame is laid over the lit one in the mode alternate, for a camera that '
        'moves between the two: translation follows a shift, affine a turn as well. Either costs '
        'milliseconds a frame, and needs a scene with texture.',
        choices=tuple(REGISTRATIONS),
    ),
    Parameter(
        'threshold.method',
        'sigma_window',
        'How the window about the peak is found. The default follows the width of the blob; the '
        'others are those of the thesis, made for its location methods.',
        choices=tuple(THRESHOLDS),
    ),
    Parameter(
        'threshold.sigmas',
        3.0,
        "Half-width of sigma_window in standard deviations of the blob. The thesis' optimum is "
        '2.8; what lies further out adds noise to all methods but maximum likelihood.',
        least=1.0,
        most=10.0,
    ),
    Parameter(
        'threshold.extension',
        2,
        'Pixels that histogram_extended adds on each side, to take in the tails.',
        least=0,
        most=64,
        unit='px',
    ),
    Parameter(
        'max_blob',
        128,
        'Greatest half-width of the window; what is wider is no target.',
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


class Target:
    """
    The topics of one light.

    Parameters
    ----------
    node : Node
        Publishes them.
    topic : str
        What their names begin with: target, or target/<name>.
    lost_after_ns : int
        Time without the light, by the stamps, after which it is no longer visible.

    """

    def __init__(self, node: Node, topic: str, lost_after_ns: int) -> None:
        self._lost_after_ns = lost_after_ns
        self._windows, self._infos, self._visible = (
            node.create_publisher(
                kind, f'{topic}/{name}', qos, qos_overriding_options=overridable()
            )
            for kind, name, qos in (
                (Image, 'window/image_raw', IMAGE_OUT),
                (CameraInfo, 'window/camera_info', IMAGE_OUT),
                (Bool, 'visible', STATE),
            )
        )
        self._seen_ns: int | None = None
        self._said_visible: bool | None = None

    def publish(self, window: Window, frame_id: str, info: CameraInfo) -> None:
        """Publish the window; it is sent first: its receiver works while the rest follows."""
        self._windows.publish(from_window(window, frame_id))
        self._infos.publish(stamped(of_window(info, window), window.stamp_ns, frame_id))

    def visible(self, stamp_ns: int, seen: bool) -> bool:
        """Tell whether the light is in view at a frame's stamp, and publish it on change."""
        if seen:
            self._seen_ns = stamp_ns
        visible = self._seen_ns is not None and 0 <= (
            stamp_ns - self._seen_ns
        ) <= self._lost_after_ns
        if visible is not self._said_visible:
            self._visible.publish(Bool(data=visible))
            self._said_visible = visible
        return visible


class SegmenterNode(Node):
    """See the module's first line; the work is `blob_tracker.segmentation.Segmenter`'s."""

    def __init__(self) -> None:
        super().__init__('segmenter')
        settings = declare(self, PARAMETERS)
        try:
            codes = codes_from_text(settings['flash.codes'])
            flash = flash_by_name(
                settings['flash.mode'],
                min_snr=settings['min_snr'],
                max_pair_interval=settings['max_pair_interval'],
                registration=settings['registration'],
                frequency=settings['flash.frequency'],
                duty=settings['flash.duty'],
                frames=settings['flash.frames'],
                codes=codes,
                frames_per_bit=settings['flash.frames_per_bit'],
                bit_errors=settings['flash.bit_errors'],
            )
        except ValueError as error:
            raise ParameterError(f"parameters 'flash': {error}") from None
        threshold = threshold_by_name(
            settings['threshold.method'],
            sigmas=settings['threshold.sigmas'],
            extension=settings['threshold.extension'],
        )
        self._segmenter = Segmenter(
            flash=flash, threshold=threshold, max_blob=settings['max_blob']
        )
        self._health = Health(
            self, 'no frames arrive; is a camera publishing camera/image_raw and camera_info?'
        )
        topics = {'': 'target'}
        if settings['flash.mode'] == 'coded':
            topics = {name: f'target/{name}' for name in codes}
        lost_after_ns = int(1e9 * settings['lost_after'])
        self._targets = {
            name: Target(self, topic, lost_after_ns) for name, topic in topics.items()
        }
        subscribe(self, 'camera', self._health, self._segment)

    def _segment(self, image: Image, info: CameraInfo) -> None:
        """Look for the lights in the next frame; publish the window of each that is there."""
        try:
            frame = to_frame(image, info)
            found = dict(self._segmenter.sightings(frame))
        except MessageError as error:
            self._health.fault(ERROR, f'camera/image_raw: {error}')
            return
        except FrameError as error:
            self._health.fault(WARN, f'camera/image_raw: {error}')
            return
        self._health.count('frames')
        for name, window in found.items():
            self._health.count('windows')
            self._targets[name].publish(window, image.header.frame_id, info)
        if not found:
            self._health.show('last frame without target', self._segmenter.reason)
        visible = [
            target.visible(frame.stamp_ns, name in found)
            for name, target in self._targets.items()
        ]
        if found:
            self._health.ok('target in view')
        elif not any(visible):
            self._health.ok(f'no target: {self._segmenter.reason}')


def main() -> None:
    """Run the node."""
    sys.exit(run(SegmenterNode, compile_ahead))

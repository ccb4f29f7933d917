"""The images of a topic as they come, for a command that runs beside the nodes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
import time

from blob_tracker.capture.fields import Weaver
from blob_tracker.ros.diagnostics.connections import why_silent
from blob_tracker.ros.endpoints.pairing import INFO, info_topic, StampPairing
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.image import placed, sensor_of, to_whole_frame
from blob_tracker.ros.process import shut_down
from blob_tracker.types import Frame
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CameraInfo, Image

PATIENCE_S = 10.0  # s without an image: what published it is not there
LISTEN_S = 0.1  # s after which Ctrl-C is looked for
# One: whoever takes long over an image gets the newest next, not those that came meanwhile.
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class NoImagesError(RuntimeError):
    """A topic on which no usable image comes; the message says what to look at."""


def live_images(
    topic: str, *, woven: bool = False
) -> Iterator[tuple[Frame, tuple[int, int] | None]]:
    """
    Yield the images of a topic, always the newest, until the caller ends.

    Parameters
    ----------
    topic : str
        Name of the topic.
    woven : bool
        Whether the fields of interlaced pictures, of which the camera_info beside the images
        tells, are put together.

    Yields
    ------
    Frame, (int, int) or None
        With crop and binning, and the size of the whole sensor, px, as far as a camera_info
        beside the images tells of them.

    Raises
    ------
    NoImagesError
        If none comes within 10 s, or one cannot be used.
    KeyboardInterrupt
        On Ctrl-C.

    """
    # Without handlers of rclpy's own Ctrl-C stays Python's, and the node outlives it.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('calibrate')
    arrived: list[tuple[Image, CameraInfo | None]] = []
    pairing = StampPairing(lambda image, info: arrived.append((image, info)))
    newest: dict[str, CameraInfo] = {}
    weaver = Weaver()

    def take(image: Image) -> None:
        if woven and node.count_publishers(info_topic(topic)):
            pairing.image(image)
        else:
            arrived.append((image, newest.get(INFO)))

    def take_info(info: CameraInfo) -> None:
        newest[INFO] = info
        if woven:
            pairing.camera_info(info)

    try:
        try:
            node.create_subscription(Image, topic, take, NEWEST)
            node.create_subscription(CameraInfo, info_topic(topic), take_info, NEWEST)
        except InvalidTopicNameException:
            raise NoImagesError(f"'{topic}' is neither a folder nor the name of a topic") from None
        waited_since = time.monotonic()
        while True:
            rclpy.spin_once(node, timeout_sec=LISTEN_S)
            if not arrived:
                if time.monotonic() - waited_since > PATIENCE_S:
                    known = dict(node.get_topic_names_and_types()).items()
                    there = sorted(name for name, types in known if Image.__name__ in
                                   (each.rpartition('/')[2] for each in types)
                                   and node.count_publishers(name))
                    if reason := why_silent(node):
                        raise NoImagesError(reason)
                    raise NoImagesError(
                        f"there is no folder '{topic}', and no image came on the topic of that "
                        f'name within {PATIENCE_S:.0f} s; images are published on '
                        + (', '.join(there) or 'no topic: start the camera node')
                    )
                continue
            message, info = arrived.pop()
            try:
                frame = to_whole_frame(message)
            except MessageError as error:
                raise NoImagesError(f'{topic}: {error}') from None
            waited_since = time.monotonic()
            sensor = None
            if info is not None:
                with suppress(MessageError):  # one of another size says nothing of these
                    frame, sensor = placed(frame, info), sensor_of(info)
            whole = weaver.whole(frame, sensor[1]) if woven and sensor else frame
            if whole is not None:
                yield whole, sensor
                waited_since = time.monotonic()
    finally:
        node.destroy_node()
        shut_down()

"""Images with the camera_info of the same stamp."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

from blob_tracker.ros.health import Health, WARN
from blob_tracker.ros.qos import IMAGE_IN, overridable
from blob_tracker.ros.stamp import to_ns
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

DEPTH = 10  # messages that wait for their partner; the queue of either topic holds as many


class StampPairing:
    """
    Hand over an image and a camera_info as soon as both of one stamp are there.

    Parameters
    ----------
    deliver : callable
        Called with each pair.

    """

    def __init__(self, deliver: Callable[[Image, CameraInfo], None]) -> None:
        self._deliver = deliver
        self._images: OrderedDict[int, Image] = OrderedDict()
        self._infos: OrderedDict[int, CameraInfo] = OrderedDict()

    @property
    def lonely_images(self) -> int:
        """Images that wait in vain so far, `DEPTH` at most."""
        return len(self._images)

    def image(self, message: Image) -> None:
        """Take an image."""
        info = self._infos.pop(to_ns(message.header.stamp), None)
        if info is None:
            _keep(self._images, to_ns(message.header.stamp), message)
        else:
            self._pair(message, info)

    def camera_info(self, message: CameraInfo) -> None:
        """Take a camera_info."""
        image = self._images.pop(to_ns(message.header.stamp), None)
        if image is None:
            _keep(self._infos, to_ns(message.header.stamp), message)
        else:
            self._pair(image, message)

    def _pair(self, image: Image, info: CameraInfo) -> None:
        """Deliver a pair, and give up what is older: its partner was lost on the way."""
        stamp_ns = to_ns(image.header.stamp)
        for waiting in (self._images, self._infos):
            for old in [key for key in waiting if key < stamp_ns]:
                del waiting[old]
        self._deliver(image, info)


def _keep(waiting: OrderedDict[int, object], stamp_ns: int, message: object) -> None:
    """Let a message wait, and drop the one that has waited longest when there are too many."""
    waiting[stamp_ns] = message
    if len(waiting) > DEPTH:
        waiting.popitem(last=False)


class FramePairs:
    """
    Subscribe to `topic`/image_raw and `topic`/camera_info and hand over their pairs.

    Parameters
    ----------
    node : Node
        The node that consumes them.
    topic : str
        What both names begin with.
    health : Health
        Hears of images that come without a camera_info.
    deliver : callable
        Called with each pair.

    """

    def __init__(
        self, node: Node, topic: str, health: Health, deliver: Callable[[Image, CameraInfo], None]
    ) -> None:
        self._topic = topic
        self._health = health
        self._pairing = StampPairing(deliver)
        for kind, name, take in (
            (Image, 'image_raw', self._take_image),
            (CameraInfo, 'camera_info', self._pairing.camera_info),
        ):
            node.create_subscription(
                kind, f'{topic}/{name}', take, IMAGE_IN, qos_overriding_options=overridable()
            )

    def _take_image(self, message: Image) -> None:
        self._pairing.image(message)
        if self._pairing.lonely_images >= DEPTH:
            self._health.fault(
                WARN,
                f'{self._topic}/image_raw comes without a {self._topic}/camera_info of the same '
                'stamp; publish one with each image',
            )

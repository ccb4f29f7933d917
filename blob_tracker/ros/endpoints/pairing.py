"""Images with the camera_info of the same stamp."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from blob_tracker.ros.diagnostics.connections import Publishers
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.lost_messages import LostMessages
from blob_tracker.ros.endpoints.qos import IMAGE_IN, subscription
from blob_tracker.ros.messages.stamp import to_ns
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

INFO = 'sensor_msgs/msg/CameraInfo'
DEPTH = 10  # messages that wait for their partner; the queue of either topic holds as many
_Message = TypeVar('_Message', Image, CameraInfo)


def info_topic(topic: str) -> str:
    """Return where the camera_info of an image topic is: beside it."""
    return ''.join([*topic.rpartition('/')[:2], 'camera_info'])


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

    @property
    def lonely_infos(self) -> int:
        """camera_infos that wait in vain so far, `DEPTH` at most."""
        return len(self._infos)

    def image(self, message: Image) -> None:
        """Take an image."""
        stamp_ns = to_ns(message.header.stamp)
        # The stamps of a topic grow: what is later came before they jumped back.
        _drop_later(self._images, stamp_ns)
        info = self._infos.pop(stamp_ns, None)
        if info is None:
            _keep(self._images, stamp_ns, message)
        else:
            self._pair(message, info)

    def camera_info(self, message: CameraInfo) -> None:
        """Take a camera_info."""
        stamp_ns = to_ns(message.header.stamp)
        _drop_later(self._infos, stamp_ns)
        image = self._images.pop(stamp_ns, None)
        if image is None:
            _keep(self._infos, stamp_ns, message)
        else:
            self._pair(image, message)

    def _pair(self, image: Image, info: CameraInfo) -> None:
        """Deliver a pair, and give up what is older: its partner was lost on the way."""
        stamp_ns = to_ns(image.header.stamp)
        for waiting in (self._images, self._infos):
            for old in [key for key in waiting if key < stamp_ns]:
                del waiting[old]
        self._deliver(image, info)

    def forget(self, after_ns: int) -> None:
        """Give up what waits and has a later stamp, ns."""
        for waiting in (self._images, self._infos):
            _drop_later(waiting, after_ns)


def _drop_later(waiting: OrderedDict[int, _Message], stamp_ns: int) -> None:
    """Drop what has a later stamp."""
    for later in [key for key in waiting if key > stamp_ns]:
        del waiting[later]


def _keep(waiting: OrderedDict[int, _Message], stamp_ns: int, message: _Message) -> None:
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
        self._node = node
        self._topic = topic
        self._health = health
        self._pairing = StampPairing(deliver)
        self._lost = LostMessages(node, f'{topic}/image_raw', health)
        self._info_publishers = Publishers()
        health.watch(self._check_infos)
        self._subscriptions = (
            subscription(
                node, Image, f'{topic}/image_raw', self._take_image, IMAGE_IN, self._lost.lost
            ),
            subscription(node, CameraInfo, f'{topic}/camera_info', self._take_info, IMAGE_IN),
        )

    def forget(self, after_ns: int) -> None:
        """Give up what waits for its partner and has a later stamp, ns."""
        self._pairing.forget(after_ns)

    def _check_infos(self) -> None:
        """See who publishes the camera_info."""
        topic = self._node.resolve_topic_name(f'{self._topic}/camera_info')
        self._info_publishers.check(
            each for each in self._node.get_publishers_info_by_topic(topic)
            if each.topic_type == INFO
        )

    @property
    def _mixed(self) -> bool:
        """Whether one of the topics is that of several cameras."""
        return self._lost.mixed or self._info_publishers.several

    def _take_image(self, message: Image, information: Mapping[str, int | None]) -> None:
        self._lost.took(len(message.data), information)
        if self._mixed:
            # What differs from one camera to the other flashes as a target does.
            if self._lost.mixed:
                self._say_mixed('image_raw', self._lost.publishers)
            else:
                self._say_mixed('camera_info', self._info_publishers.names)
            return
        self._pairing.image(message)
        if self._pairing.lonely_images >= DEPTH:
            self._say_lonely('image_raw', 'camera_info')

    def _take_info(self, message: CameraInfo) -> None:
        if self._mixed:  # no image waits for it
            return
        self._pairing.camera_info(message)
        if self._pairing.lonely_infos >= DEPTH:
            self._say_lonely('camera_info', 'image_raw')

    def _say_mixed(self, kind: str, names: Sequence[str]) -> None:
        """Say whose messages come in turns."""
        # The numbers of the messages may tell of the second before the graph was looked at.
        known = f' ({", ".join(names)})' if len(names) > 1 else ''
        self._health.fault(
            ERROR,
            f'{self._topic}/{kind}: several nodes publish it{known}, and none of the images is '
            'used; stop all but one',
        )

    def _say_lonely(self, one: str, other: str) -> None:
        """Say that what should come in pairs does not."""
        self._health.fault(
            WARN,
            f'{self._topic}/{one} comes without a {self._topic}/{other} of the same stamp; '
            'publish one with each',
        )

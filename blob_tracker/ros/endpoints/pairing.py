"""Images with the camera_info of the same stamp, or of the nearest one."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import partial
from typing import Any, TypeVar

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.ros.diagnostics.connections import full_name, Publishers
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.lost_messages import LostMessages
from blob_tracker.ros.endpoints.nearest import nearest, Nearness
from blob_tracker.ros.endpoints.qos import IMAGE_IN, subscription
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.messages.stamp import to_ns
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

INFO = 'sensor_msgs/msg/CameraInfo'
DEPTH = 10  # messages that wait for their partner; the queue of either topic holds as many
QUIET_NS = 10**6  # an offset that is told in the log alone: less than exposures are known to
# How images may come (`image_transport`): the message, and what image_transport adds to the name.
TRANSPORTS: dict[str, tuple[Any, str]] = {
    'raw': (Image, ''), 'compressed': (CompressedImage, '/compressed'),
}
_Message = TypeVar('_Message', Image, CompressedImage, CameraInfo)
Deliver = Callable[[Any, CameraInfo], None]


def info_topic(topic: str) -> str:
    """Return where the camera_info of an image topic is: beside it."""
    return ''.join([*topic.rpartition('/')[:2], 'camera_info'])


class StampPairing:
    """
    Hand over an image and a camera_info as soon as both of one stamp are there.

    That of the nearest stamp does as well, see `Nearness`.

    Parameters
    ----------
    deliver : callable
        Called with each pair.
    exact : bool
        Whether the stamps must be equal: each window has a place of its own, and the camera_info
        of a neighbour would put it elsewhere.

    Attributes
    ----------
    offset_ns : int or None
        Stamp of the last camera_info less that of the image nearest to it, ns, whether they were
        paired or not; None if nothing came on one of the topics.

    """

    def __init__(self, deliver: Deliver, *, exact: bool = False) -> None:
        self.offset_ns: int | None = None
        self._exact = exact
        self._deliver = deliver
        self._images: OrderedDict[int, Image | CompressedImage] = OrderedDict()
        self._infos: OrderedDict[int, CameraInfo] = OrderedDict()
        self._nearness = Nearness()

    @property
    def lonely_images(self) -> int:
        """Images that wait in vain so far, `DEPTH` at most."""
        return len(self._images)

    @property
    def lonely_infos(self) -> int:
        """camera_infos that wait in vain so far, `DEPTH` at most."""
        return len(self._infos)

    def image(self, message: Image | CompressedImage) -> None:
        """Take an image."""
        stamp_ns = to_ns(message.header.stamp)
        self._nearness.image(stamp_ns)
        # The stamps of a topic grow: what is later came before they jumped back.
        _drop_later(self._images, stamp_ns)
        partner_ns = self._partner(self._infos, stamp_ns)
        if partner_ns is None:
            _keep(self._images, stamp_ns, message)
        else:
            self._pair(message, self._infos.pop(partner_ns))

    def camera_info(self, message: CameraInfo) -> None:
        """Take a camera_info."""
        stamp_ns = to_ns(message.header.stamp)
        _drop_later(self._infos, stamp_ns)
        partner_ns = self._partner(self._images, stamp_ns)
        if partner_ns is None:
            _keep(self._infos, stamp_ns, message)
        else:
            self._pair(self._images.pop(partner_ns), message)

    def clear(self) -> None:
        """Give up all that waits."""
        self._images.clear()
        self._infos.clear()

    def _partner(self, waiting: Mapping[int, Any], stamp_ns: int) -> int | None:
        """Return the stamp of what waits for a message of this one; None if nothing does."""
        if not waiting:
            return None
        nearest_ns = nearest(waiting, stamp_ns)
        offset_ns = nearest_ns - stamp_ns
        self.offset_ns = offset_ns if waiting is self._infos else -offset_ns
        near = offset_ns == 0 if self._exact else self._nearness.is_near(offset_ns)
        return nearest_ns if near else None

    def _pair(self, image: Image | CompressedImage, info: CameraInfo) -> None:
        """Deliver a pair, and give up what is older: its partner was lost on the way."""
        for waiting, message in ((self._images, image), (self._infos, info)):
            stamp_ns = to_ns(message.header.stamp)
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
    remedy : str
        What to do about images without a camera_info, besides publishing one with each.
    transport : str
        See `set_transport`.
    exact : bool
        See `StampPairing`.

    Attributes
    ----------
    stand_in : CameraModel or None
        The camera of images for which there is no camera_info, or one without a calibration.

    """

    def __init__(
        self, node: Node, topic: str, health: Health, deliver: Deliver, *, remedy: str = '',
        transport: str = 'raw', exact: bool = False,
    ) -> None:
        self.stand_in: CameraModel | None = None
        self._node = node
        self._topic = topic
        self._health = health
        self._deliver = deliver
        self._remedy = remedy
        self._pairing = StampPairing(self._paired, exact=exact)
        self._alone = False  # whether the images are used without a camera_info of the topic
        self._arriving: Image | CompressedImage | None = None
        self._told_offset = False
        # A remapping of the images holds for what image_transport adds to their name.
        self._base = node.resolve_topic_name(f'{topic}/image_raw')
        self._losses: dict[str, LostMessages] = {}  # by the transport
        self._info_publishers = Publishers()
        self._subscriptions = [
            subscription(node, CameraInfo, f'{topic}/camera_info', self._take_info, IMAGE_IN),
        ]
        self.set_transport(transport)
        health.watch(self._check)

    def set_transport(self, transport: str) -> None:
        """
        Take the images in a transport, and no longer in another one.

        Parameters
        ----------
        transport : str
            One of `TRANSPORTS`; compressed images come on `topic`/image_raw/compressed.

        """
        kind, added = TRANSPORTS[transport]
        self._transport = transport
        self._images = f'{self._topic}/image_raw{added}'
        if transport not in self._losses:
            name = self._base + added if added else self._images
            lost = LostMessages(self._node, name, self._health, _type_of(kind))
            # It stays, see `process.run`.
            self._subscriptions.append(subscription(
                self._node, kind, name, partial(self._take_image, kind), IMAGE_IN, lost.lost))
            self._losses[transport] = lost
        self._lost = self._losses[transport]
        self._kind = kind
        self._pairing.clear()

    def forget(self, after_ns: int) -> None:
        """Give up what waits for its partner and has a later stamp, ns."""
        self._pairing.forget(after_ns)

    def _check(self) -> None:
        """See who publishes the images and the camera_info."""
        topic = self._node.resolve_topic_name(f'{self._topic}/camera_info')
        self._info_publishers.check(
            each for each in self._node.get_publishers_info_by_topic(topic)
            if each.topic_type == INFO
        )
        self._alone = self._alone or not self._info_publishers.count
        if self._remedy:  # a window has one transport
            self._look_for_others()

    def _look_for_others(self) -> None:
        """Say where images come on the topic of the other transport alone."""
        if self._publishers_of(self._transport):
            return
        for other in TRANSPORTS:
            names = self._publishers_of(other)
            if names:
                self._health.fault(
                    WARN,
                    f'nothing publishes {self._images}, and {", ".join(names)} publishes '
                    f'{self._topic}/image_raw{TRANSPORTS[other][1]}; set '
                    f'image_transport: {other}',
                )

    def _publishers_of(self, transport: str) -> list[str]:
        """Return the names of those that publish the images in a transport."""
        kind, added = TRANSPORTS[transport]
        return sorted({
            full_name(each)
            for each in self._node.get_publishers_info_by_topic(f'{self._base}{added}')
            if each.topic_type == _type_of(kind)
        })

    @property
    def _mixed(self) -> bool:
        """Whether one of the topics is that of several cameras."""
        return self._lost.mixed or self._info_publishers.several

    def _take_image(
        self, kind: type, message: Image | CompressedImage,
        information: Mapping[str, int | None],
    ) -> None:
        if kind is not self._kind:
            return
        self._lost.took(len(message.data), information)
        if self._mixed:
            # What differs from one camera to the other flashes as a target does.
            if self._lost.mixed:
                self._say_mixed('image_raw', self._lost.publishers)
            else:
                self._say_mixed('camera_info', self._info_publishers.names)
            return
        self._arriving = message
        self._pairing.image(message)
        self._arriving = None
        if self._pairing.lonely_images >= DEPTH:
            self._alone = True
            self._say_lonely('image_raw', 'camera_info')
        if self._alone and self.stand_in is not None and self._pairing.lonely_images:
            self._health.show('camera_info', 'that of camera_info_url')
            info = from_camera_model(self.stand_in, self.stand_in.width, self.stand_in.height)
            info.header = message.header
            self._deliver(message, info)

    def _take_info(self, message: CameraInfo) -> None:
        if self._mixed:  # no image waits for it
            return
        self._pairing.camera_info(message)
        if self._pairing.lonely_infos >= DEPTH:
            self._say_lonely('camera_info', 'image_raw')

    def _paired(self, image: Image | CompressedImage, info: CameraInfo) -> None:
        """Hand over a pair, unless its image was used when it came."""
        if self._alone and self.stand_in is not None:
            self._alone = False
            self._pairing.clear()  # those were used as well
            if image is not self._arriving:
                return
        self._tell_offset()
        if self.stand_in is not None and not info.k[0]:
            try:
                info = _calibrated(info, self.stand_in)
            except CalibrationError as error:
                self._health.fault(ERROR, f'camera_info_url: {error}')
                return
            self._health.show('camera_info', 'of the topic, calibrated by camera_info_url')
        elif self.stand_in is not None:
            self._health.show('camera_info', 'of the topic, not of camera_info_url')
        self._deliver(image, info)

    def _tell_offset(self) -> None:
        """Say how far the stamps of a pair are apart."""
        offset_ns = self._pairing.offset_ns
        if not offset_ns:
            if self._told_offset:
                self._health.show('camera_info offset (ms)', '0')
            return
        self._health.show('camera_info offset (ms)', f'{offset_ns / 1e6:.3f}')
        sentence = (
            f'{self._topic}/camera_info has stamps {abs(offset_ns) / 1e6:.3f} ms '
            f'{"after" if offset_ns > 0 else "before"} those of {self._images}; each image is '
            'used with the nearest, within half of the interval of the images; a driver should '
            'give both one stamp'
        )
        if abs(offset_ns) > QUIET_NS:
            self._health.fault(WARN, sentence)
        elif not self._told_offset:
            self._node.get_logger().info(sentence)
        self._told_offset = True

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
        if self.stand_in is not None and not self._info_publishers.count:
            return  # which is why it was given
        offset_ns = self._pairing.offset_ns
        apart = '' if not offset_ns else f' (they are {abs(offset_ns) / 1e9:.6f} s apart)'
        used = 'camera_info_url is used' if self.stand_in is not None else 'publish one with each'
        remedy = self._remedy if self.stand_in is None else ''
        self._health.fault(
            WARN,
            f'{self._topic}/{one} comes without a {self._topic}/{other} of the same stamp{apart}; '
            f'{used}{remedy}',
        )


def _type_of(kind: Any) -> str:
    """Return the name of a message as the graph has it."""
    return f'sensor_msgs/msg/{kind.__name__}'


def _calibrated(info: CameraInfo, model: CameraModel) -> CameraInfo:
    """Return a camera_info, crop and binning as they are, with the calibration of a model."""
    if not (info.width and info.height):  # as camera_info_manager has them without a calibration
        made = from_camera_model(model, model.width, model.height)
    else:
        made = copy(info)
        whole = from_camera_model(
            model, int(info.width), int(info.height),
            sensor_size=(int(info.width), int(info.height)),
        )
        for name in ('distortion_model', 'd', 'k', 'r', 'p'):
            setattr(made, name, getattr(whole, name))
    made.header = info.header
    return made

"""The frames of a bag: its images, each with the camera_info of its stamp or the nearest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
import sys
from types import SimpleNamespace
from typing import Any

from blob_tracker.ros.bags import Bag, opened, READABLE, RecordingError, Topic
from blob_tracker.ros.endpoints.nearest import nearest, Nearness
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.compressed_image import to_whole_frame as of_compressed
from blob_tracker.ros.messages.image import placed, to_whole_frame as of_image
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Frame

IMAGE, COMPRESSED = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'
IMAGES = {IMAGE: of_image, COMPRESSED: of_compressed}  # what makes a frame of a message
CAMERA_INFO = 'sensor_msgs/msg/CameraInfo'
USUAL = 'camera/image_raw'  # the topic of the camera node
LONGEST_QUEUE = 64  # images that wait for their camera_info: of 1 s at 60 Hz
Recorded = tuple[Any, int]  # an image, and the time at which it was recorded, ns
MOST_INFOS = 10_000  # that wait for their image: they are small, and some bags have them first


def _warn(sentence: str) -> None:
    print(sentence, file=sys.stderr)


def recorded_frames(
    path: Path, topic: str | None = None, *, paired: bool = False,
    warn: Callable[[str], None] = _warn,
) -> Iterator[tuple[Frame, Any | None]]:
    """
    Yield the frames of a topic in the order in which they were recorded.

    Parameters
    ----------
    path : Path
        The bag: a folder, or a file of it.
    topic : str, optional
        Name of the topic; a slash in front does not matter. If it is left out it is
        camera/image_raw or the only one.
    paired : bool
        Whether each has the camera_info of its stamp or, as the nodes have it, of the nearest,
        which gives crop and binning; an image without one is left out. Else the images are taken
        as whole pictures.
    warn : callable
        Is told what is wrong with a bag that can be read nevertheless.

    Yields
    ------
    Frame, CameraInfo or None
        With the stamp of the image, or the time at which it was recorded where it has none.

    Raises
    ------
    RecordingError
        The bag cannot be read, has no images on that topic, or one that cannot be used; after the
        last image if fewer or more came than the bag says that it has.

    """
    pairs = _Pairs(path, warn)
    unstamped: Counter[Topic] = Counter()
    with opened(path) as bag:
        if bag.remark:
            warn(bag.remark)
        chosen = image_topic(bag, topic)
        of_info = info_topic(bag, chosen) if paired else None
        topics = [chosen] if of_info is None else [chosen, of_info]
        for message in bag.messages(topics):
            decoded = bag.decoded(message)
            stamp_ns = to_ns(decoded.header.stamp)
            if not stamp_ns:  # those without go together by their order
                unstamped[message.topic] += 1
                stamp_ns = -unstamped[message.topic]
            if not paired:
                yield _frame(bag, chosen, decoded, None, message.recorded_ns), None
                continue
            if message.topic == of_info:
                found = pairs.info(stamp_ns, _todays(decoded))
            else:
                found = pairs.image(stamp_ns, (decoded, message.recorded_ns))
            for (image, recorded_ns), info in found:
                yield _frame(bag, chosen, image, info, recorded_ns), info
    alone = pairs.alone
    if alone:
        warn(f'{path}: {alone} images have no camera_info of their stamp and are left out')


class _Pairs:
    """Images, each with the time of recording, and the camera_infos that wait for each other."""

    def __init__(self, path: Path, warn: Callable[[str], None]) -> None:
        self._path, self._warn = path, warn
        self._images: dict[int, Recorded] = {}
        self._infos: dict[int, Any] = {}
        self._nearness = Nearness()
        self._given_up = 0  # images
        self._told = False

    @property
    def alone(self) -> int:
        """Images that found no camera_info."""
        return self._given_up + len(self._images)

    def image(self, stamp_ns: int, image: Recorded) -> Iterator[tuple[Recorded, Any]]:
        """Take an image, and yield those that have a camera_info now, with it."""
        told_before = self._nearness.tolerance_ns > 0.0
        if stamp_ns > 0:
            self._nearness.image(stamp_ns)
        self._images[stamp_ns] = image
        # The first one had to wait until it was known how near is near.
        for waiting_ns in [stamp_ns] if told_before else list(self._images):
            if self._infos:
                info_ns = waiting_ns
                if info_ns not in self._infos:
                    info_ns = nearest(self._infos, waiting_ns)
                yield from self._pair(waiting_ns, info_ns)
        if len(self._images) > LONGEST_QUEUE:
            del self._images[next(iter(self._images))]
            self._given_up += 1

    def info(self, stamp_ns: int, info: Any) -> Iterator[tuple[Recorded, Any]]:
        """Take a camera_info, and yield the image that it belongs to, with it."""
        self._infos[stamp_ns] = info
        if self._images:
            exact = stamp_ns in self._images
            yield from self._pair(
                stamp_ns if exact else nearest(self._images, stamp_ns), stamp_ns)
        if len(self._infos) > MOST_INFOS:
            del self._infos[next(iter(self._infos))]

    def _pair(self, image_ns: int, info_ns: int) -> Iterator[tuple[Recorded, Any]]:
        """Yield an image and a camera_info if they belong together."""
        offset_ns = info_ns - image_ns
        if not self._nearness.is_near(offset_ns):
            return
        if offset_ns and not self._told:
            self._told = True
            self._warn(
                f'{self._path}: camera_info has stamps {abs(offset_ns) / 1e6:.3f} ms '
                f'{"after" if offset_ns > 0 else "before"} those of the images; each image goes '
                'with the nearest'
            )
        yield self._images.pop(image_ns), self._infos.pop(info_ns)


def recorded_info(bag: Bag, topic: str | None = None) -> Any | None:
    """
    Return the first camera_info that belongs to a topic of images; None if there is none.

    Raises
    ------
    RecordingError
        The bag cannot be read, or has no images on that topic.

    """
    of_info = info_topic(bag, image_topic(bag, topic))
    if of_info is not None:
        for message in bag.messages([of_info]):
            return _todays(bag.decoded(message))
    return None


def recorded_count(bag: Bag, topic: str | None = None) -> int:
    """Return how many images there are of the topic that `recorded_frames` takes."""
    return bag.topics[image_topic(bag, topic)]


def image_topic(bag: Bag, name: str | None = None) -> Topic:
    """
    Return the topic of a bag whose images are meant.

    Parameters
    ----------
    bag : Bag
        Open.
    name : str, optional
        As of `recorded_frames`. Compressed copies of an image's own topic do not count beside it.

    Raises
    ------
    RecordingError
        If there is none, or no one could tell which.

    """
    there = {
        topic.name.strip('/'): topic for topic, count in bag.topics.items()
        if topic.kind in IMAGES and topic.encoding in READABLE and count
    }
    alone = [
        each for each in there
        if not any(each != other and each.startswith(f'{other}/') for other in there)
    ]
    wanted = (name or USUAL).strip('/')
    if wanted in there:
        return there[wanted]
    if name is None and len(alone) == 1:
        return there[alone[0]]
    names = ', '.join(sorted(topic.name for topic in there.values()))
    if not names:
        what = f'{bag.path} has no images on any topic'
    elif name is None:
        what = f'{bag.path} has images on several topics'
    else:
        what = f'{bag.path} has no images on {name}'
    raise RecordingError(what + (f': set --topic to one of {names}' if names else ''))


def info_topic(bag: Bag, images: Topic) -> Topic | None:
    """Return the topic of the camera_info that belongs to a topic of images."""
    name = info_name(images.name, images.kind).strip('/')
    return next((
        topic for topic, count in bag.topics.items()
        if topic.name.strip('/') == name and topic.kind == CAMERA_INFO and count
        and topic.encoding in READABLE
    ), None)


def info_name(images: str, kind: str) -> str:
    """Return where the camera_info is that belongs to images of this name and kind."""
    if kind == COMPRESSED:  # camera/image_raw/compressed
        images = images.rpartition('/')[0]
    return f'{images.rpartition("/")[0]}/camera_info'


def _todays(info: Any) -> Any:
    """Return a camera_info with the names of ROS 2; ROS 1 has K, D, R and P."""
    if hasattr(info, 'k'):
        return info
    return SimpleNamespace(**{name.lower(): value for name, value in vars(info).items()})


def _frame(bag: Bag, topic: Topic, image: Any, info: Any | None, recorded_ns: int) -> Frame:
    """Return the frame of an image, with the time of recording if it has no stamp."""
    try:
        frame = IMAGES[topic.kind](image)
        if info is not None:
            frame = placed(frame, info)
    except MessageError as error:
        seconds = (recorded_ns - bag.start_ns) / 1e9
        raise RecordingError(f'{bag.path}, {topic.name} at {seconds:.3f} s: {error}') from None
    return frame if to_ns(image.header.stamp) else replace(frame, stamp_ns=recorded_ns)

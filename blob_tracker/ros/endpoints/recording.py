"""The images of a rosbag2 bag, mcap or sqlite3."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TYPE_CHECKING

from blob_tracker.capture.fields import Weaver
from blob_tracker.ros.endpoints.pairing import info_topic
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.image import field_and_height, to_pixels
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Pixels

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

IMAGE, INFO = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CameraInfo'
# Ubuntu 24.04 has no package of it, and its pip refuses to install beside apt (PEP 668).
NO_ROSBAGS = (
    'rosbags is not installed: python3 -m pip install --break-system-packages rosbags (in a '
    'virtual environment without that option)'
)


class RecordingError(ValueError):
    """A bag that holds no such images; the message says what is wrong and what would be right."""


def recorded_images(
    bag: Path, topic: str, *, interpolate: bool = True, woven: bool = False
) -> Iterator[tuple[float, Pixels]]:
    """
    Yield the images of a topic in the order in which they were recorded.

    Parameters
    ----------
    bag : Path
        Folder of the bag.
    topic : str
        Name of the topic; a slash in front does not matter.
    interpolate : bool
        See `to_pixels`.
    woven : bool
        Whether the fields of interlaced pictures, of which the camera_info beside the images
        tells, are put together.

    Yields
    ------
    float, (h, w) array
        Stamp of the image, s since the first, or the time at which it was recorded where it has
        none; and the pixels as `to_pixels` gives them.

    Raises
    ------
    RecordingError
        Where the bag cannot be read, or has no images on that topic.

    """
    with _opened(bag, topic) as (reader, connections):
        first_ns: int | None = None
        kinds = _fields(reader, info_topic(topic)) if woven else {}
        weaver = Weaver()
        for connection, recorded_ns, data in reader.messages(connections):
            image: Any = reader.deserialize(data, connection.msgtype)
            stamp_ns = to_ns(image.header.stamp) or recorded_ns
            first_ns = stamp_ns if first_ns is None else first_ns
            seconds = (stamp_ns - first_ns) / 1e9
            try:
                pixels = to_pixels(image, interpolate=interpolate)
            except MessageError as error:
                raise RecordingError(f'{bag}, {topic} at {seconds:.3f} s: {error}') from None
            picture = weaver.add(pixels, *kinds.get(to_ns(image.header.stamp), (None, 0)))
            if picture is not None:
                yield seconds, picture


def _fields(reader: AnyReader, topic: str) -> dict[int, tuple[int | None, int]]:
    """Return what `field_and_height` does of each camera_info, by its stamp, ns."""
    infos = [
        each for each in reader.connections
        if each.msgtype == INFO and each.topic.strip('/') == topic.strip('/')
    ]
    messages: Any = (
        reader.deserialize(data, connection.msgtype)
        for connection, _, data in (reader.messages(infos) if infos else ())
    )
    return {to_ns(info.header.stamp): field_and_height(info) for info in messages}


def recorded_count(bag: Path, topic: str) -> int:
    """Return how many images `recorded_images` will yield; raises as it does."""
    with _opened(bag, topic) as (_, connections):
        return sum(connection.msgcount for connection in connections)


@contextmanager
def _opened(bag: Path, topic: str) -> Iterator[tuple[AnyReader, list[Connection]]]:
    """Open a bag and find the connections of an image topic."""
    with opened(bag) as reader:
        images = [each for each in reader.connections if each.msgtype == IMAGE and each.msgcount]
        connections = [each for each in images if each.topic.strip('/') == topic.strip('/')]
        if not connections:
            there = ', '.join(sorted({each.topic for each in images}))
            raise RecordingError(
                f'{bag} has no images on {topic}'
                + (f': set --topic to one of {there}' if there else ', nor on any other topic')
            )
        yield reader, connections


@contextmanager
def opened(bag: Path) -> Iterator[AnyReader]:
    """
    Open a bag of any distribution of ROS 2.

    Parameters
    ----------
    bag : Path
        Folder of the bag.

    Yields
    ------
    AnyReader
        Open.

    Raises
    ------
    RecordingError
        Where the bag cannot be read.

    """
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import get_typestore, Stores
    except ImportError:
        raise RecordingError(f'{NO_ROSBAGS}, or use `ros2 bag play`') from None
    if not bag.exists():
        raise RecordingError(f'there is no bag {bag}')
    if bag.is_file() and bag.suffix == '.bag':
        raise RecordingError(
            f'{bag} is a bag of ROS 1; convert it: rosbags-convert --src {bag} '
            f'--dst {bag.with_suffix("")}'
        )
    try:
        # Bags of distributions before Jazzy do not tell their types.
        reader = AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY))
        with reader:
            yield reader
    except (AnyReaderError, OSError) as error:
        raise RecordingError(f'{bag} is not a bag that can be read: {error}') from None

"""The images of a bag, as they were recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
import sys

from blob_tracker.colour import grey_pixels
from blob_tracker.ros.bags import Bag, opened, READABLE, RecordingError, Topic
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.compressed_image import to_whole_frame as of_compressed
from blob_tracker.ros.messages.image import to_whole_frame as of_image
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Frame, Pixels

# What makes a frame of a message, by its type.
IMAGES = {
    'sensor_msgs/msg/Image': of_image,
    'sensor_msgs/msg/CompressedImage': of_compressed,
}
USUAL = 'camera/image_raw'  # the topic of the camera node


def _warn(sentence: str) -> None:
    print(sentence, file=sys.stderr)


def recorded_images(
    path: Path, topic: str | None = None, *, interpolate: bool = True,
    warn: Callable[[str], None] = _warn,
) -> Iterator[tuple[float, Pixels]]:
    """
    Yield the images of a topic in the order in which they were recorded, without their colours.

    Parameters
    ----------
    path : Path
        The bag: a folder, or a file of it.
    topic : str, optional
        Name of the topic; a slash in front does not matter. Where it is left out it is
        camera/image_raw or the only one.
    interpolate : bool
        See `grey_pixels`.
    warn : callable
        Is told what is wrong with the bag, where it can be read nevertheless.

    Yields
    ------
    float, (h, w) array
        Stamp of the image, s since the first, or the time at which it was recorded where it has
        none; and its pixels as `grey_pixels` gives them.

    Raises
    ------
    RecordingError
        Where the bag cannot be read, or has no images on that topic; after the last image where
        fewer or more came than the bag says that it has.

    """
    first_ns: int | None = None
    for frame in _frames(path, topic, warn):
        first_ns = frame.stamp_ns if first_ns is None else first_ns
        try:
            pixels = grey_pixels(frame, interpolate=interpolate)
        except ValueError as error:
            raise RecordingError(f'{path}: {error}') from None
        yield (frame.stamp_ns - first_ns) / 1e9, pixels


def recorded_count(path: Path, topic: str | None = None) -> int:
    """Return how many images `recorded_images` will yield; raises as it does."""
    with opened(path) as bag:
        return bag.topics[image_topic(bag, topic)]


def image_topic(bag: Bag, name: str | None = None) -> Topic:
    """
    Return the topic of a bag whose images are meant.

    Parameters
    ----------
    bag : Bag
        Open.
    name : str, optional
        As of `recorded_images`. Compressed copies of an image's own topic do not count beside it.

    Raises
    ------
    RecordingError
        Where there is none, or no one could tell which.

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


def _frames(path: Path, topic: str | None, warn: Callable[[str], None]) -> Iterator[Frame]:
    """Yield the frames of an image topic, with the time of recording where one has no stamp."""
    with opened(path) as bag:
        if bag.remark:
            warn(bag.remark)
        chosen = image_topic(bag, topic)
        first_ns: int | None = None
        for message in bag.messages([chosen]):
            image = bag.decoded(message)
            first_ns = message.recorded_ns if first_ns is None else first_ns
            try:
                frame = IMAGES[chosen.kind](image)
            except MessageError as error:
                seconds = (message.recorded_ns - first_ns) / 1e9
                raise RecordingError(
                    f'{path}, {chosen.name} at {seconds:.3f} s: {error}') from None
            if not to_ns(image.header.stamp):
                frame = replace(frame, stamp_ns=message.recorded_ns)
            yield frame

"""The frames of a bag: its images, each with the camera_info of its stamp."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from blob_tracker.ros.endpoints.recording import IMAGE, opened, RecordingError
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.image import to_frame, to_whole_frame
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.types import Frame

CAMERA_INFO = 'sensor_msgs/msg/CameraInfo'
LONGEST_QUEUE = 64  # images that wait for their camera_info: of 1 s at 60 Hz


def info_topic(topic: str) -> str:
    """Return the topic of the camera_info that belongs to a topic of images."""
    return f'{topic.strip("/").rpartition("/")[0]}/camera_info'.lstrip('/')


def recorded_info(bag: Path, topic: str) -> Any | None:
    """
    Return the first camera_info that belongs to a topic of images; None where there is none.

    Raises
    ------
    RecordingError
        The bag cannot be read.

    """
    with opened(bag) as reader:
        connections = _connections(reader, {info_topic(topic): CAMERA_INFO})
        for connection, _, data in reader.messages(connections):
            return reader.deserialize(data, connection.msgtype)
    return None


def recorded_frames(
    bag: Path, topic: str, *, paired: bool
) -> Iterator[tuple[Frame, Any | None]]:
    """
    Yield the frames of a topic in the order in which they were recorded.

    Parameters
    ----------
    bag : Path
        Of the bag.
    topic : str
        Of the images; a slash in front does not matter.
    paired : bool
        Whether each has the camera_info of its stamp, which gives crop and binning, as the nodes
        have it; an image without one is left out. Else the images are taken as whole pictures.

    Yields
    ------
    Frame, CameraInfo or None
        With the stamp of the image, or the time at which it was recorded where it has none.

    Raises
    ------
    RecordingError
        The bag cannot be read, or holds an image that cannot be used.

    """
    wanted = {topic.strip('/'): IMAGE}
    if paired:
        wanted[info_topic(topic)] = CAMERA_INFO
    images: dict[int, tuple[Any, int]] = {}  # by the stamp, with the time of recording
    infos: dict[int, Any] = {}
    with opened(bag) as reader:
        for connection, recorded_ns, data in reader.messages(_connections(reader, wanted)):
            message: Any = reader.deserialize(data, connection.msgtype)
            stamp_ns = to_ns(message.header.stamp)
            if connection.msgtype == CAMERA_INFO:
                infos[stamp_ns] = message
            elif paired:
                images[stamp_ns] = message, recorded_ns
            else:
                yield _frame(bag, message, None, recorded_ns), None
            if stamp_ns in images and stamp_ns in infos:
                image, recorded_ns = images.pop(stamp_ns)
                info = infos.pop(stamp_ns)
                yield _frame(bag, image, info, recorded_ns), info
            for waiting in (images, infos):
                if len(waiting) > LONGEST_QUEUE:
                    del waiting[next(iter(waiting))]


def _connections(reader: Any, wanted: dict[str, str]) -> list[Any]:
    """Return the connections of these topics and types."""
    return [
        each for each in reader.connections
        if wanted.get(each.topic.strip('/')) == each.msgtype and each.msgcount
    ]


def _frame(bag: Path, image: Any, info: Any | None, recorded_ns: int) -> Frame:
    if not to_ns(image.header.stamp):
        image.header.stamp.sec, image.header.stamp.nanosec = divmod(recorded_ns, 10**9)
    try:
        return to_whole_frame(image) if info is None else to_frame(image, info)
    except MessageError as error:
        stamp = to_ns(image.header.stamp) / 1e9
        raise RecordingError(f'{bag}, the image of {stamp:.3f} s: {error}') from None

"""Images from bags: ours, with all that is checked, beside rosbags and OpenCV by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
import resource
from statistics import median
from tempfile import TemporaryDirectory
import time
from typing import Any

from blob_tracker.colour import grey_pixels
from blob_tracker.ros.endpoints.recording import recorded_frames
import cv2
import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

Tick = Callable[[str], None]

WIDTH, HEIGHT = 640, 480
IMAGES = 300
STEP_NS = 33_333_333
NOISE = 30  # DN: so much of a pixel does not compress
IMAGE, COMPRESSED = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'
MCAP, SQLITE3 = StoragePlugin.MCAP, StoragePlugin.SQLITE3
# Name: storage, None for ROS 1; compression; type of the messages.
BAGS: dict[str, tuple[StoragePlugin | None, CompressionMode, str]] = {
    'mcap': (MCAP, CompressionMode.NONE, IMAGE),
    'mcap, zstd': (MCAP, CompressionMode.STORAGE, IMAGE),
    'mcap, zstd by message': (MCAP, CompressionMode.MESSAGE, IMAGE),
    'mcap, JPEG': (MCAP, CompressionMode.NONE, COMPRESSED),
    'sqlite3': (SQLITE3, CompressionMode.NONE, IMAGE),
    'ROS 1': (None, CompressionMode.NONE, IMAGE),
}


@dataclass(frozen=True)
class Row:
    """
    One kind of bag.

    Parameters
    ----------
    bag : str
        Its kind.
    rate, reference : float
        Images a second, ours and by hand: medians over the repeats.
    ratio : float
        Median over the repeats of the one over the other.
    memory : float
        MB by which a process that reads it grows at most.

    """

    bag: str
    rate: float
    reference: float
    ratio: float
    memory: float


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(BAGS)


def run(repeats: int, tick: Tick) -> list[Row]:
    """Return the row of each kind of bag."""
    rows = []
    for name in BAGS:
        tick(f'files {name}')
        rows.append(measure(name, repeats, IMAGES))
    return rows


def measure(name: str, repeats: int, images: int) -> Row:
    """Return the row of one kind; both read the bag in turns."""
    with TemporaryDirectory() as folder:
        bag = write(Path(folder), name, images)
        took = [(_seconds(_ours, bag, images), _seconds(_by_hand, bag, images))
                for _ in range(repeats)]
        with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as process:
            memory = process.submit(_growth, bag).result()
    return Row(
        name, images / median(each[0] for each in took), images / median(each[1] for each in took),
        median(hand / ours for ours, hand in took), memory,
    )


def write(folder: Path, name: str, images: int) -> Path:
    """Write a bag of one kind; returns its place."""
    storage, compression, kind = BAGS[name]
    types = get_typestore(Stores.ROS2_JAZZY)
    message = _message(types, kind)
    data = types.serialize_cdr(message, kind)
    if storage is None:
        bag = folder / 'bag.bag'
        with Writer1(bag) as writer:
            topic = writer.add_connection(
                '/image', kind, typestore=get_typestore(Stores.ROS1_NOETIC))
            data = types.cdr_to_ros1(data, kind)
            for index in range(images):
                writer.write(topic, index * STEP_NS, data)
        return bag
    bag = folder / 'bag'
    recorder = Writer(bag, version=9, storage_plugin=storage)
    if compression != CompressionMode.NONE:
        recorder.set_compression(compression, CompressionFormat.ZSTD)
    with recorder:
        channel = recorder.add_connection('/image', kind, typestore=types)
        for index in range(images):
            recorder.write(channel, index * STEP_NS, data)
    return bag


def _message(types: Any, kind: str) -> Any:
    random = np.random.default_rng(1)
    pixels = random.integers(0, NOISE, (HEIGHT, WIDTH), np.uint8)
    stamp = types.types['builtin_interfaces/msg/Time'](1, 0)
    header = types.types['std_msgs/msg/Header'](stamp, 'optical')
    if kind == COMPRESSED:
        return types.types[kind](header, 'jpeg', cv2.imencode('.jpg', pixels)[1].ravel())
    return types.types[kind](header, HEIGHT, WIDTH, 'mono8', 0, WIDTH, pixels.ravel())


def _ours(bag: Path) -> Iterator[Any]:
    return (grey_pixels(frame, interpolate=True) for frame, _ in recorded_frames(bag))


def _by_hand(bag: Path) -> Iterator[Any]:
    """Yield the pixels as whoever knows what is in the bag would get them."""
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages(reader.connections):
            message: Any = reader.deserialize(data, connection.msgtype)
            if connection.msgtype == COMPRESSED:
                yield cv2.imdecode(message.data, cv2.IMREAD_UNCHANGED)
            else:
                yield message.data.reshape(message.height, message.step)


def _seconds(read: Callable[[Path], Iterator[Any]], bag: Path, images: int) -> float:
    began = time.perf_counter()
    count = sum(pixels.shape == (HEIGHT, WIDTH) for pixels in read(bag))
    took = time.perf_counter() - began
    assert count == images
    return took


def _growth(bag: Path) -> float:
    """Return by how many MB this process grows at most while it reads, after the first image."""
    images = _ours(bag)
    next(images)
    before = _peak()
    for _ in images:
        pass
    return _peak() - before


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6

"""Bags of 59 images whose pixels and stamps are known, in every storage and state."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import shutil
import sqlite3
from typing import Any

from blob_tracker.colour import grey_pixels
from blob_tracker.ros.endpoints.recording import recorded_frames
import cv2
from mcap.writer import CompressionType, IndexType, Writer as McapWriter
import numpy as np
from rosbags.interfaces import (
    Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime,
)
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import (
    CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer,
)
from rosbags.typesys import get_typestore, Stores

COUNT = 59
START_NS = 1_700_000_000_000_000_000
STEP_NS = 33_333_333
WIDTH, HEIGHT = 48, 32
TOPIC = '/camera/image_raw'
FLASH = Path(__file__).parents[1] / 'bags' / 'flash_sqlite3'
KIND = 'sensor_msgs/msg/Image'
COMPRESSED = 'sensor_msgs/msg/CompressedImage'
TYPES = get_typestore(Stores.ROS2_JAZZY)
TYPES1 = get_typestore(Stores.ROS1_NOETIC)
SCHEMA = TYPES.generate_msgdef(KIND, ros_version=2)[0].encode()
_NO_TIME = QosTime(0, 0)
QOS = Qos(
    QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, QosDurability.VOLATILE, _NO_TIME, _NO_TIME,
    QosLiveliness.AUTOMATIC, _NO_TIME, False,
)


def pixels(index: int) -> np.ndarray:
    """Return the image of a number: noise, which does not compress."""
    return np.random.default_rng(index).integers(0, 256, (HEIGHT, WIDTH), np.uint8)


def stamp_ns(index: int) -> int:
    """Return the stamp of the image of a number."""
    return START_NS + index * STEP_NS


def header(index: int) -> Any:
    """Return the header of the message of a number."""
    seconds, nanoseconds = divmod(stamp_ns(index), 10**9)
    time = TYPES.types['builtin_interfaces/msg/Time'](seconds, nanoseconds)
    return TYPES.types['std_msgs/msg/Header'](time, 'optical')


def image(index: int, content: np.ndarray | None = None, encoding: str = 'mono8') -> bytes:
    """Return the serialized image of a number."""
    content = pixels(index) if content is None else content
    height, width = content.shape[:2]
    if encoding in ('nv12', 'nv21'):
        height = height * 2 // 3
    message = TYPES.types[KIND](
        header(index), height, width, encoding, 0, content.nbytes // content.shape[0],
        content.view(np.uint8).ravel())
    return bytes(TYPES.serialize_cdr(message, KIND))


def compressed(index: int, content: np.ndarray, suffix: str, form: str) -> bytes:
    """Return the serialized compressed image of a number."""
    data = cv2.imencode(suffix, content)[1]
    message = TYPES.types[COMPRESSED](header(index), form, data.ravel())
    return bytes(TYPES.serialize_cdr(message, COMPRESSED))


def write_rosbag2(
    folder: Path, storage: StoragePlugin = StoragePlugin.MCAP, *,
    compression: CompressionMode = CompressionMode.NONE, version: Any = 9,
) -> Path:
    """Write a bag as rosbag2 does; returns its file."""
    writer = Writer(folder, version=version, storage_plugin=storage)
    if compression != CompressionMode.NONE:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(
            TOPIC, KIND, typestore=TYPES, offered_qos_profiles=[QOS])
        for index in range(COUNT):
            writer.write(connection, stamp_ns(index), image(index))
    (file,) = (each for each in folder.iterdir() if each.name != 'metadata.yaml')
    return file


def write_mcap(
    path: Path, *, chunking: bool = True, compression: CompressionType = CompressionType.ZSTD,
    indexes: IndexType = IndexType.ALL, order: Any = range(COUNT), statistics: bool = True,
    others: bool = False, chunk_size: int = 8000, repeat: bool = True,
) -> Path:
    """
    Write an mcap file with the library of its authors.

    Topics that ROS 2 does not know are beside the images where `others` are asked for, one
    message after each image.
    """
    with path.open('wb') as file:
        writer = McapWriter(
            file, chunk_size=chunk_size, compression=compression, index_types=indexes,
            use_chunking=chunking, use_statistics=statistics, repeat_channels=repeat,
            repeat_schemas=repeat)
        writer.start('' if others else 'ros2')
        schema = writer.register_schema(KIND, 'ros2msg', SCHEMA)
        channel = writer.register_channel(TOPIC, 'cdr', schema)
        strangers = list(_strangers(writer)) if others else []
        for index in order:
            writer.add_message(channel, stamp_ns(index), image(index), stamp_ns(index))
            for stranger in strangers:
                writer.add_message(stranger, stamp_ns(index) + 1, b'{}', stamp_ns(index))
        writer.finish()
    return path


def _strangers(writer: McapWriter) -> Iterator[int]:
    """Yield channels whose definitions are no ROS messages, or cannot be parsed."""
    for topic, name, encoding, definition, serialized in (
        ('/proto', 'foxglove.CompressedImage', 'protobuf', b'\x0a\x01', 'protobuf'),
        ('/json', 'anything', 'jsonschema', b'{"type": "object"}', 'json'),
        ('/service/_service_event', 'a/srv/B_Event', 'ros2msg', b'C[<=1] request\n', 'cdr'),
        ('/char', 'a/msg/Char', 'ros2msg', b'char[2 c\n', 'cdr'),
        ('/wide', 'a/msg/Wide', 'ros2msg', b'wstring<=3 w "\n', 'cdr'),
        ('/empty', 'a/msg/Empty', '', b'', 'cdr'),
    ):
        schema = writer.register_schema(name, encoding, definition)
        yield writer.register_channel(topic, serialized, schema)
    yield writer.register_channel('/schemaless', 'json', 0)


def write_rosbag1(path: Path, compression: Any = None, kind: str = KIND) -> Path:
    """Write a bag of ROS 1."""
    writer = Writer1(path)
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        connection = writer.add_connection(TOPIC, kind, typestore=TYPES1)
        for index in range(COUNT):
            raw = bytes(TYPES.cdr_to_ros1(image(index), kind))
            writer.write(connection, stamp_ns(index), raw)
    return path


def recorded_pixels(
    bag: Path, topic: str | None = None, **options: Any
) -> Iterator[tuple[float, np.ndarray]]:
    """Yield the images of a bag without their colours, and their stamps since the first, s."""
    first_ns: int | None = None
    for frame, _ in recorded_frames(bag, topic, **options):
        first_ns = frame.stamp_ns if first_ns is None else first_ns
        yield (frame.stamp_ns - first_ns) / 1e9, grey_pixels(frame, interpolate=True)


def rewritten(folder: Path, *replacements: tuple[str, str]) -> Path:
    """Return a copy of the bag of flashes with other words in what is said of its topics."""
    shutil.copytree(FLASH, folder)
    metadata = folder / 'metadata.yaml'
    words = metadata.read_text()
    with sqlite3.connect(folder / 'flash_sqlite3.db3') as database:
        for old, new in replacements:
            words = words.replace(old, new)
            database.execute(
                'UPDATE topics SET name = replace(name, ?, ?), '
                'offered_qos_profiles = replace(offered_qos_profiles, ?, ?)', (old, new, old, new),
            )
    database.close()
    metadata.write_text(words)
    return folder


def of_best_effort(folder: Path) -> Path:
    """Return a copy of the bag of flashes, as a driver would leave it that offers no more."""
    return rewritten(
        folder, ('reliability: reliable', 'reliability: best_effort'),
        ('reliability: 1', 'reliability: 2'),
    )


def of_compressed(folder: Path, name: str = '/camera/image_raw', kind: str = '.png') -> Path:
    """Return a bag of the flashes as image_transport compresses them, with their camera_info."""
    infos = f'{name.rpartition("/")[0]}/camera_info'
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        of_images, of_infos = (
            writer.add_connection(topic, name, typestore=TYPES, offered_qos_profiles=[QOS])
            for topic, name in (
                (f'{name}/compressed', COMPRESSED), (infos, 'sensor_msgs/msg/CameraInfo'))
        )
        with Reader(FLASH) as reader:
            for connection, recorded_ns, raw in reader.messages():
                if connection.topic == '/camera/camera_info':
                    writer.write(of_infos, recorded_ns, raw)
                elif connection.topic == TOPIC:
                    found: Any = TYPES.deserialize_cdr(raw, KIND)
                    pixels = found.data.reshape(found.height, found.width)
                    data = cv2.imencode(kind, pixels)[1].ravel()
                    message = TYPES.types[COMPRESSED](
                        found.header, f'mono8; {kind[1:]} compressed ', data)
                    writer.write(
                        of_images, recorded_ns, TYPES.serialize_cdr(message, COMPRESSED))
    return folder

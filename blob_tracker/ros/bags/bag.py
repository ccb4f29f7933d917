"""
A bag of any storage: its topics, its messages, and whether they are all there.

A topic's name, type and encoding are enough: its definition, which the file holds as well, is
never looked at, so that one that cannot be parsed shuts nobody out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, ExitStack
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TYPE_CHECKING

from blob_tracker.ros.bags.metadata import files_of, Metadata, NAME, read_metadata, SUFFIXES
from blob_tracker.ros.bags.topic import BagFile, CDR, Message, RecordingError, ROS1, Topic

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

# Ubuntu 24.04 has no package of it, and its pip refuses to install beside apt (PEP 668).
NO_ROSBAGS = (
    'rosbags 0.11 or newer is not installed: python3 -m pip install --break-system-packages -U '
    'rosbags (in a virtual environment without the first option)'
)


class Bag:
    """
    An open bag.

    Attributes
    ----------
    path : Path
        What was opened.
    topics : dict of Topic to int
        How many messages of each topic will come.
    remark : str
        What is wrong with it, and how much of it is there; empty if all is well.
    start_ns : int
        Time of the first message, ns; 0 without any.

    """

    def __init__(self, path: Path, metadata: Metadata, files: Iterable[BagFile]) -> None:
        self.path = path
        spans = [(each, each.span()) for each in files]
        # Files of a bag follow each other; a name does not always tell in which order.
        self._files = [each for each, span in sorted(
            ((each, span) for each, span in spans if span is not None), key=lambda pair: pair[1])]
        self.start_ns = min((span[0] for _, span in spans if span is not None), default=0)
        said = metadata.promised or {}
        self._promised: dict[str, int] | None = None
        if metadata.promised is not None:
            self._promised = _by_name([said])
        elif all(each.promised is not None for each, _ in spans):
            self._promised = _by_name(each.promised or {} for each, _ in spans)
        counts = self._promised
        if counts is None:
            counts = _by_name(each.counts() for each, _ in spans)
        profiles = {topic.name: topic.qos for topic in said}
        found = [topic for each, _ in spans for topic in each.topics]
        names = {topic.name for topic in found}
        # What is promised and in no file is one of them: nothing of it will come.
        found += [topic for topic in said if topic.name not in names]
        self.topics = {
            replace(topic, qos=profiles.get(topic.name) or topic.qos): counts.get(topic.name, 0)
            for topic in found
        }
        flaws = [*metadata.flaws, *(flaw for each, _ in spans for flaw in each.flaws)]
        self._flaws = frozenset(flaws)
        self.remark = ''
        if flaws:
            there = sum(sum(each.counts().values()) for each, _ in spans)
            last_ns = max((span[1] for _, span in spans if span is not None), default=0)
            self.remark = (
                f'{path}: {"; ".join(flaws)}. {there} messages of '
                f'{(last_ns - self.start_ns) / 1e9:.3f} s are there'
            )

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """
        Yield the messages of topics in the order of their times.

        Raises
        ------
        RecordingError
            After the last one, where they are not as many as the bag says that it has.

        """
        came = dict.fromkeys((each.name for each in topics), 0)
        first_ns = last_ns = 0
        for file in self._files:
            for message in file.messages(topics):
                came[message.topic.name] += 1
                first_ns = first_ns or message.recorded_ns
                last_ns = message.recorded_ns
                yield self._whole(message)
        promised = self._promised or {}
        differing = [
            f'{name}: {promised[name]} messages are promised and {count} came'
            for name, count in came.items() if promised.get(name, count) != count
        ]
        flaws = dict.fromkeys(flaw for each in self._files for flaw in each.flaws)
        # What was not seen before it was read may hide messages of which nobody knows.
        if differing or flaws.keys() - self._flaws:
            remedy = (
                f'. To take what is there, move {NAME} away, or rebuild it: `ros2 bag reindex`'
                if (self.path / NAME).is_file() else ''
            )
            raise RecordingError(
                f'{self.path}, {"; ".join([*differing, *flaws])}. What came is of '
                f'{(last_ns - first_ns) / 1e9:.3f} s{remedy}'
            )

    def decoded(self, message: Message) -> Any:
        """Return a message of a type that ROS' common interfaces have, with its fields."""
        topic = message.topic
        try:
            if topic.encoding == ROS1:
                return _typestore(ROS1).deserialize_ros1(message.data, topic.kind)
            return _typestore(CDR).deserialize_cdr(message.data, topic.kind)
        except Exception as error:  # what a damaged message makes it raise comes from anywhere
            raise RecordingError(
                f'{self.path}, {topic.name}: a message is not a {topic.kind}: {error}') from None

    def serialized(self, message: Message) -> bytes:
        """Return a message as ROS 2 sends it; raises RecordingError where it cannot be made so."""
        topic = message.topic
        if topic.encoding == CDR:
            return message.data
        try:
            return bytes(_typestore(CDR).ros1_to_cdr(message.data, topic.kind))
        except Exception as error:  # as above
            raise RecordingError(
                f'{self.path}, {topic.name}: a message is not a {topic.kind}: {error}') from None

    def _whole(self, message: Message) -> Message:
        """Return a message that was perhaps compressed by itself as it was before that."""
        from blob_tracker.ros.bags.compression import (
            decompressed, DECOMPRESSION_FAULTS, ZSTD_MAGIC,
        )

        # CDR begins with a zero.
        if message.topic.encoding != CDR or not message.data.startswith(ZSTD_MAGIC):
            return message
        try:
            return message._replace(data=decompressed(message.data, 'zstd'))
        except DECOMPRESSION_FAULTS:
            raise RecordingError(
                f'{self.path}, {message.topic.name}: a compressed message is damaged') from None


def is_bag(path: Path) -> bool:
    """Tell whether a file or a folder is a bag, by its name or the names in it."""
    if path.is_dir():
        return (path / NAME).is_file() or bool(files_of(path))
    return path.is_file() and path.name.endswith((*SUFFIXES, '.bag.active'))


@contextmanager
def opened(path: Path) -> Iterator[Bag]:
    """
    Open a bag, of ROS 2 by its folder or one of its files, of ROS 1 by its file.

    Parameters
    ----------
    path : Path
        It need not have its metadata.yaml, nor be whole: `Bag.remark`.

    Yields
    ------
    Bag
        Open.

    Raises
    ------
    RecordingError
        If nothing of it can be read.

    """
    if not path.exists():
        raise RecordingError(f'there is no bag {path}')
    try:
        from blob_tracker.ros.bags.any_file import opened_file
    except ImportError:
        raise RecordingError(f'{NO_ROSBAGS}, or use `ros2 bag play`') from None
    try:
        metadata = read_metadata(path) if path.is_dir() else Metadata([path])
        if not metadata.files:
            raise RecordingError(
                f'{path} is not a bag that can be read: no file of its name ends in '
                f'{", ".join(SUFFIXES)}')
        with ExitStack() as stack:
            files: list[BagFile] = []
            for file in metadata.files:
                try:
                    files.append(opened_file(file, stack, metadata.flaws))
                except RecordingError as error:
                    if path.is_file() or len(metadata.files) == 1:
                        raise
                    metadata.flaws.append(str(error))
            if not files:
                raise RecordingError(f'{path}: {"; ".join(metadata.flaws)}')
            yield Bag(path, metadata, files)
    except OSError as error:
        reason = error.strerror or error
        raise RecordingError(f'{path} is not a bag that can be read: {reason}') from None


@lru_cache
def _typestore(encoding: str) -> Typestore:
    """Return the types of the common interfaces; it takes 0.1 s."""
    from rosbags.typesys import get_typestore, Stores

    return get_typestore(Stores.ROS1_NOETIC if encoding == ROS1 else Stores.ROS2_JAZZY)


def _by_name(counts: Iterable[dict[Topic, int]]) -> dict[str, int]:
    """Return the sums of messages of topics by their names."""
    found: dict[str, int] = {}
    for each in counts:
        for topic, count in each.items():
            found[topic.name] = found.get(topic.name, 0) + count
    return found

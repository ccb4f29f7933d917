"""A .bag file of ROS 1, which rosbags reads."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from blob_tracker.ros.bags.topic import Message, RecordingError, ROS1, Topic
from rosbags.rosbag1 import Reader

MAGIC = b'#ROSBAG V'


class Ros1File:
    """A bag of ROS 1; see `BagFile`."""

    def __init__(self, path: Path) -> None:
        self.promised: dict[Topic, int] | None = None
        self.flaws: list[str] = []
        self._reader = Reader(path)
        try:
            self._reader.open()
        except Exception as error:  # a damaged file makes it raise whatever comes first
            if 'not indexed' in str(error):
                raise RecordingError(
                    f'{path} has no index, its recorder was killed: `rosbag reindex {path}` of '
                    'ROS 1 rebuilds it'
                ) from None
            raise RecordingError(f'{path} is a bag of ROS 1 that is damaged: {error}') from None
        self._topics = {
            each.id: Topic(each.topic, each.msgtype, ROS1) for each in self._reader.connections
        }
        # Several nodes may have published on one topic.
        self.topics = list(dict.fromkeys(self._topics.values()))

    def counts(self) -> dict[Topic, int]:
        """Return how many messages of each topic are there, by the index."""
        found = dict.fromkeys(self.topics, 0)
        for each in self._reader.connections:
            found[self._topics[each.id]] += each.msgcount
        return found

    def span(self) -> tuple[int, int] | None:
        """Return the time of the first message and of the last, ns; None without any."""
        if not self._reader.message_count:
            return None
        return self._reader.start_time, self._reader.end_time - 1

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Yield the messages of topics in the order of their times."""
        wanted = [each for each in self._reader.connections if self._topics[each.id] in topics]
        if not wanted:
            return  # to the library none means all
        stream = self._reader.messages(wanted)
        while True:
            try:
                connection, recorded_ns, data = next(stream)
            except StopIteration:
                return
            except Exception as error:  # as above
                self.flaws.append(f'it is damaged: {error}')
                return
            yield Message(self._topics[connection.id], recorded_ns, data)

    def close(self) -> None:
        """Close it."""
        self._reader.close()

"""What a bag's files have in common: topics, messages, and how much of them there is."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

CDR = 'cdr'
ROS1 = 'ros1'
READABLE = (CDR, ROS1)


class RecordingError(ValueError):
    """A bag that holds no such messages; says what is wrong and what would be right."""


@dataclass(frozen=True)
class Topic:
    """
    A topic of a bag.

    Parameters
    ----------
    name : str
        As it was recorded.
    kind : str
        Of its messages: 'sensor_msgs/msg/Image'; empty if the file does not tell.
    encoding : str
        How they are serialized: CDR, ROS1, or what else is named.
    qos : list of dict
        The QoS profiles that were offered.

    """

    name: str
    kind: str
    encoding: str = CDR
    qos: list[dict[str, Any]] = field(default_factory=list, compare=False)


class Message(NamedTuple):
    """A message as it was recorded, ns of the recorder's clock."""

    topic: Topic
    recorded_ns: int
    data: bytes


class BagFile(Protocol):
    """
    One file of a bag, open.

    Attributes
    ----------
    topics : list of Topic
        All that it tells of.
    promised : dict or None
        How many messages of each topic it says that it has; None if it does not say.
    flaws : list of str
        What is wrong with it, as far as it was read: 'it ends in the middle of a record'.

    """

    topics: list[Topic]
    promised: dict[Topic, int] | None
    flaws: list[str]

    def counts(self) -> dict[Topic, int]:
        """Return how many messages of each topic are there."""

    def span(self) -> tuple[int, int] | None:
        """Return the time of the first message and of the last, ns; None without any."""

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Yield the messages of topics in the order of their times."""

    def close(self) -> None:
        """Close it."""


def todays_kind(kind: str) -> str:
    """Return ROS 2's name of a type: ROS 1 wrote 'sensor_msgs/Image'."""
    return kind.replace('/', '/msg/', 1) if kind.count('/') == 1 else kind

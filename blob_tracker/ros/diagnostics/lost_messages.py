"""Messages that did not arrive, how many, and why."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from blob_tracker.ros.diagnostics.connections import full_name, Publishers
from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.diagnostics.interleaving import Interleaving, SILENCE_NS
from blob_tracker.ros.diagnostics.losses import grave
from blob_tracker.ros.diagnostics.shared_memory import (
    DEFAULT_BYTES, export, same_host, segment_size,
)
from rclpy.event_handler import QoSMessageLostInfo
from rclpy.node import Node
from rclpy.utilities import get_rmw_implementation_identifier

WINDOW_S = 5  # s over which losses are a share
IMAGE = 'sensor_msgs/msg/Image'
QUEUE = 10  # messages: less room than a publisher's queue is the cause of a loss


class LostMessages:
    """
    Count the messages of a topic that were lost on the way or in the queue of this node.

    The middleware tells of the first. The publisher numbers its messages: what is missing
    beyond those was replaced by newer ones before this node took it.

    Parameters
    ----------
    node : Node
        Subscribes.
    topic : str
        Name of the topic.
    health : Health
        Is told.
    kind : str
        Of the messages, as the graph has it.

    """

    def __init__(self, node: Node, topic: str, health: Health, kind: str = IMAGE) -> None:
        self._node = node
        self._topic = node.resolve_topic_name(topic)
        self._health = health
        self._kind = kind
        self._publishers = Publishers()
        self._size = 0  # bytes of a message
        self._taken = self._lost = self._late = 0  # so far
        self._last: tuple[int, int] | None = None  # number and time of the last message
        self._interleaving = Interleaving()
        # Since the publisher began: numbers that are missing, and what became of them.
        self._missing = self._missing_lost = self._missing_late = 0
        self._seconds: deque[tuple[int, int, int]] = deque([(0, 0, 0)], maxlen=WINDOW_S + 1)
        health.watch(self._tell)

    def lost(self, event: QoSMessageLostInfo) -> None:
        """Take the middleware's word for messages that were lost on the way."""
        self._lost += event.total_count_change
        self._missing_lost += event.total_count_change
        self._health.count('images lost on the way', event.total_count_change)

    def took(self, size: int, information: Mapping[str, int | None]) -> None:
        """Take note of a message of so many bytes, and of what the middleware says of it."""
        self._size = size
        self._taken += 1
        number = information['publication_sequence_number']
        sent_ns = information['source_timestamp']
        if number is None or sent_ns is None:  # not every middleware numbers them
            return
        self._interleaving.took(number, sent_ns)
        if self._last is not None:
            if 0 <= sent_ns - self._last[1] < SILENCE_NS:
                self._missing += max(number - self._last[0] - 1, 0)
            else:
                self._begin()
        self._last = number, sent_ns

    @property
    def mixed(self) -> bool:
        """
        Tell whether the messages of several publishers come in turns.

        Where there are no numbers, or one publishes seldom, the graph tells of it after a while.
        """
        return self._publishers.several or self._interleaving.mixed

    @property
    def publishers(self) -> list[str]:
        """Names of the nodes that published the topic at the last check."""
        return self._publishers.names

    def _begin(self) -> None:
        """Begin with the numbers of a publisher."""
        self._last = None
        self._missing = self._missing_lost = self._missing_late = 0

    def _tell(self) -> None:
        """Say what was lost in the last seconds."""
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        # Nothing arrives from those of another type.
        self._publishers.check(each for each in publishers if each.topic_type == self._kind)
        if len(publishers) != 1:  # each has numbers of its own; `Connections` says that there are
            self._begin()
        late = max(self._missing - self._missing_lost - self._missing_late, 0)
        if late:
            self._missing_late += late
            self._late += late
            self._health.count('images not taken in time', late)
        now = self._taken, self._lost, self._late
        taken, lost, late = (new - old for new, old in zip(now, self._seconds[0], strict=True))
        self._seconds.append(now)
        if grave(late, taken):
            self._health.fault(
                WARN,
                f'{self._topic}: this node is too slow: {late} of {late + taken} images in '
                f'{WINDOW_S} s were replaced by newer ones before it took them; give it more of '
                'the processor (see top), fewer or smaller images, or run all in one process '
                '(pipeline); for a bag that is played fast there is config/replay.yaml',
            )
        if grave(lost, taken) and len(publishers) == 1:
            self._health.fault(
                WARN,
                f'{self._topic}: {lost} of {lost + taken} images in {WINDOW_S} s were lost on the '
                f'way from {full_name(publishers[0])}: '
                f'{self._why(bytes(publishers[0].endpoint_gid))}',
            )

    def _why(self, gid: bytes) -> str:
        """Return why messages are lost on the way from this publisher."""
        ours = [
            bytes(each.endpoint_gid)
            for each in self._node.get_subscriptions_info_by_topic(self._topic)
            if full_name(each) == self._node.get_fully_qualified_name()
        ]
        if ours and not same_host(gid, ours[0]):
            return (
                'it is on another machine, and what is lost on the network is not sent again; run '
                'this node there, take a wire, or ask for reliable '
                f'(qos_overrides.{self._topic}.subscription.reliability)'
            )
        seen = segment_size(gid)
        segment = DEFAULT_BYTES if seen is None else seen
        if segment < QUEUE * self._size and 'fastrtps' in get_rmw_implementation_identifier():
            probably = 'probably ' if seen is None else ''
            return (
                f'its shared memory {probably}has {segment >> 10} KiB, and an image '
                f'{self._size >> 10}; a Fast DDS profile gives it more, unless it is dropped for '
                f'a fault in it, see doctor: in its terminal, before it starts, type: {export()}'
            )
        return 'this machine is too busy to pass them on (see top)'

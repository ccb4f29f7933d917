"""Messages that were lost on their way here, how many, and why."""

from __future__ import annotations

from collections import deque

from blob_tracker.ros.connections import full_name
from blob_tracker.ros.health import Health, WARN
from blob_tracker.ros.shared_memory import environment_of, export, same_host, segment_size
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import QoSMessageLostInfo
from rclpy.node import Node
from rclpy.utilities import get_rmw_implementation_identifier

WINDOW = 5  # s over which losses are a share
GRAVE, SEVERAL = 0.01, 2  # share and count of lost messages from which on it is worth a word
QUEUE = 10  # messages: less room than a publisher's queue is the cause of a loss


class LostMessages:
    """
    Count the messages of a topic that the middleware tells to be lost on the way, and say why.

    What was replaced by newer ones in the queue of this node it does not tell; the stamps do, see
    `losses`.

    Parameters
    ----------
    node : Node
        Subscribes.
    topic : str
        Name of the topic.
    health : Health
        Is told.

    """

    def __init__(self, node: Node, topic: str, health: Health) -> None:
        self._node = node
        self._topic = node.resolve_topic_name(topic)
        self._health = health
        self._size = 0  # bytes of a message
        self._taken = self._lost = 0  # so far
        self._seconds: deque[tuple[int, int]] = deque([(0, 0)], maxlen=WINDOW + 1)
        # Wall time: with use_sim_time a paused bag must not silence a node.
        self._timer = node.create_timer(
            1.0, self._tell, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def lost(self, event: QoSMessageLostInfo) -> None:
        """Take the middleware's word for messages that were lost on the way."""
        self._lost += event.total_count_change
        self._health.count('images lost on the way', event.total_count_change)

    def took(self, size: int) -> None:
        """Take note of a message of so many bytes."""
        self._size = size
        self._taken += 1

    def _tell(self) -> None:
        """Say what was lost in the last seconds."""
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        now = self._taken, self._lost
        taken, lost = (new - old for new, old in zip(now, self._seconds[0], strict=True))
        self._seconds.append(now)
        if _grave(lost, taken) and len(publishers) == 1:
            self._health.fault(
                WARN,
                f'{self._topic}: {lost} of {lost + taken} images in {WINDOW} s were lost on the '
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
        theirs = environment_of(gid)
        segment = segment_size(theirs or {})
        if segment < QUEUE * self._size and 'fastrtps' in get_rmw_implementation_identifier():
            probably = 'probably ' if theirs is None else ''
            return (
                f'its shared memory {probably}has {segment >> 10} KiB for want of the Fast DDS '
                f'profile, and an image {self._size >> 10}; in its terminal, before it starts, '
                f'type: {export()}'
            )
        return 'this machine is too busy to pass them on (see top)'


def _grave(lost: int, taken: int) -> bool:
    """Tell whether so many messages were lost that it is worth a word."""
    return lost >= SEVERAL and lost > GRAVE * (lost + taken)

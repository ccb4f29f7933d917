"""Publish the messages of a rosbag2 bag, mcap or sqlite3, at the pace at which they came."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
import sys
import time

from blob_tracker.ros.bags import Bag, opened, READABLE, RecordingError, Topic
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.process import shut_down
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rich.console import Console
from rich.progress import Progress
from rosgraph_msgs.msg import Clock

QUIET = 1.0  # s without a new subscriber: all that were starting have been found
CLOCK_STEP_NS = 10_000_000  # /clock at 100 Hz of bag time, and with each message
LONGEST_QUEUE = 1000  # messages of a topic
LAST_WORDS = 2.0  # s for the subscribers to acknowledge the last messages


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker replay`."""
    parser.add_argument('bag', type=Path, help='the bag: its folder, or a file of it')
    parser.add_argument(
        '--rate', type=float, default=1.0, help='speed: 2 is twice as fast as recorded'
    )
    parser.add_argument('--clock', action='store_true', help='publish /clock for use_sim_time')
    parser.add_argument(
        '--wait',
        type=float,
        default=5.0,
        help='seconds to wait at most for subscribers before the first message',
    )
    parser.add_argument(
        '--nodes', nargs='+', default=[], metavar='NODE', help='wait for these as well'
    )
    parser.add_argument(
        '--topics', nargs='+', metavar='TOPIC', help='play these alone; without it all of the bag'
    )


def main(arguments: argparse.Namespace) -> int:
    """
    Replay a bag.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        0 when all is published, 1 where the bag cannot be read, has not what it promises, or the
        nodes of `--nodes` do not come, 2 for a wrong option, 130 after Ctrl-C.

    """
    if not arguments.rate > 0.0:
        print(f'--rate is {arguments.rate}; it must be above 0', file=sys.stderr)
        return 2
    try:
        with opened(arguments.bag) as bag:
            if bag.remark:
                print(bag.remark, file=sys.stderr)
            names = set(arguments.topics or [topic.name for topic in bag.topics])
            topics = {topic: count for topic, count in bag.topics.items() if topic.name in names}
            if not any(topics.values()):
                print(
                    f'{arguments.bag} holds no messages of {", ".join(sorted(names))}; '
                    f'its topics are {", ".join(sorted(topic.name for topic in bag.topics))}',
                    file=sys.stderr,
                )
                return 1
            rclpy.init()
            node = rclpy.create_node('replay')
            try:
                publishers = _advertise(node, topics)
                clock = node.create_publisher(Clock, '/clock', RESULT) if arguments.clock else None
                missing = _await(
                    node, set(arguments.nodes), list(publishers.values()), arguments.wait
                )
                if missing:
                    print(
                        f'nothing is played: {", ".join(sorted(missing))} of --nodes did not come '
                        f'within {arguments.wait} s; start them, or raise --wait',
                        file=sys.stderr,
                    )
                    return 1
                _play(bag, topics, publishers, clock, arguments.rate)
                return 0
            except (KeyboardInterrupt, ExternalShutdownException):
                return 130
            finally:
                node.destroy_node()
                shut_down()
    except KeyboardInterrupt:
        return 130
    except RecordingError as error:
        print(error, file=sys.stderr)
        return 1


def _advertise(node: Node, topics: Mapping[Topic, int]) -> dict[Topic, Publisher]:
    """Return a publisher for each topic of the bag, as it was offered when recorded."""
    publishers = {}
    for topic, count in topics.items():
        package, *_, name = topic.kind.split('/')
        try:
            if topic.encoding not in READABLE:
                raise ImportError
            kind = getattr(import_module(f'{package}.msg'), name)
        except (ImportError, AttributeError, ValueError):  # ValueError: a topic without a type
            print(
                f'{topic.name} is left out: {topic.kind or "its type"} is not installed here',
                file=sys.stderr,
            )
            continue
        publishers[topic] = node.create_publisher(kind, topic.name, _recorded_qos(topic, count))
    return publishers


def _recorded_qos(topic: Topic, count: int) -> QoSProfile:
    """Return the QoS that the bag remembers; reliable where it remembers none."""
    if not topic.qos:
        return RESULT
    # A number until Jazzy, a word since.
    offered = {key: str(value).lower() for key, value in topic.qos[0].items()}
    depth = offered.get('depth', '')
    return QoSProfile(
        history=(
            HistoryPolicy.KEEP_ALL if offered.get('history') in ('2', 'keep_all')
            else HistoryPolicy.KEEP_LAST
        ),
        # A subscriber is known here before it listens: what it asks for again must still be held.
        depth=max(int(depth) if depth.isdigit() else 1, min(count, LONGEST_QUEUE)),
        reliability=(
            ReliabilityPolicy.BEST_EFFORT if offered.get('reliability') in ('2', 'best_effort')
            else ReliabilityPolicy.RELIABLE
        ),
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL
            if offered.get('durability') in ('1', 'transient_local')
            else DurabilityPolicy.VOLATILE
        ),
    )


def _await(
    node: Node, awaited: set[str], publishers: list[Publisher], longest: float
) -> set[str]:
    """
    Wait until nodes and subscribers are there and no more come: none misses the beginning.

    Returns
    -------
    set of str
        The nodes that did not come within the longest time, s.

    """
    began = changed = time.monotonic()
    known = 0
    missing = set(awaited)
    while time.monotonic() - began < longest:
        count = sum(publisher.get_subscription_count() for publisher in publishers)
        absent = awaited.difference(node.get_node_names())
        if count != known or absent != missing:
            known, missing, changed = count, absent, time.monotonic()
        if known and not missing and time.monotonic() - changed >= QUIET:
            return set()
        time.sleep(0.05)
    return missing


def _play(
    bag: Bag,
    topics: Mapping[Topic, int],
    publishers: dict[Topic, Publisher],
    clock: Publisher | None,
    rate: float,
) -> None:
    """Publish the serialized messages, each at its time."""
    first_ns = bag.start_ns
    clock_ns = first_ns
    began = time.monotonic()
    try:
        # The bar goes to the standard error: the standard output stays free for pipes.
        with Progress(console=Console(stderr=True)) as progress:
            task = progress.add_task('replay', total=sum(topics.values()))
            for message in bag.messages(topics):
                stamp_ns = message.recorded_ns
                while clock is not None and clock_ns < stamp_ns:
                    _sleep_until(began + (clock_ns - first_ns) / 1e9 / rate)
                    clock.publish(Clock(clock=from_ns(clock_ns)))
                    clock_ns += CLOCK_STEP_NS
                _sleep_until(began + (stamp_ns - first_ns) / 1e9 / rate)
                if clock is not None:
                    clock.publish(Clock(clock=from_ns(stamp_ns)))
                if message.topic in publishers:
                    publishers[message.topic].publish(bag.serialized(message))
                progress.advance(task)
    except RecordingError:  # what came before it arrives all the same
        _let_arrive(publishers)
        raise
    _let_arrive(publishers)


def _let_arrive(publishers: dict[Topic, Publisher]) -> None:
    """Wait until the subscribers have the last messages, but not for ever."""
    for publisher in publishers.values():
        publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=LAST_WORDS))


def _sleep_until(moment: float) -> None:
    """Sleep until a moment of the monotonic clock."""
    pause = moment - time.monotonic()
    if pause > 0.0:
        time.sleep(pause)
    if not rclpy.ok():
        raise ExternalShutdownException

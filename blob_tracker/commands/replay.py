"""Publish the messages of a rosbag2 bag, mcap or sqlite3, at the pace at which they came."""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path
import sys
import time
from typing import Any, TYPE_CHECKING

from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.endpoints.recording import opened, RecordingError
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

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

QUIET = 1.0  # s without a new subscriber: all that were starting have been found
CLOCK_STEP_NS = 10_000_000  # /clock at 100 Hz of bag time, and with each message
LONGEST_QUEUE = 1000  # messages of a topic
LAST_WORDS = 2.0  # s for the subscribers to acknowledge the last messages


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker replay`."""
    parser.add_argument('bag', type=Path, help='folder of the bag')
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
        0 when all is published, 1 where the bag cannot be read or the nodes of `--nodes` do not
        come, 2 for a wrong option, 130 after Ctrl-C.

    """
    if not arguments.rate > 0.0:
        print(f'--rate is {arguments.rate}; it must be above 0', file=sys.stderr)
        return 2
    try:
        with opened(arguments.bag) as reader:
            topics = set(arguments.topics or reader.topics)
            connections = [c for c in reader.connections if c.topic in topics]
            if not any(connection.msgcount for connection in connections):
                print(
                    f'{arguments.bag} holds no messages of {", ".join(sorted(topics))}; '
                    f'its topics are {", ".join(sorted(reader.topics))}',
                    file=sys.stderr,
                )
                return 1
            rclpy.init()
            node = rclpy.create_node('replay')
            try:
                publishers = _advertise(node, connections)
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
                _play(reader, connections, publishers, clock, arguments.rate)
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


def _advertise(node: Node, connections: list[Connection]) -> dict[int, Publisher]:
    """Return a publisher for each connection of the bag, as it was offered when recorded."""
    publishers = {}
    for connection in connections:
        package, *_, name = connection.msgtype.split('/')
        try:
            kind = getattr(import_module(f'{package}.msg'), name)
        except (ImportError, AttributeError):
            print(
                f'{connection.topic} is left out: {connection.msgtype} is not installed here',
                file=sys.stderr,
            )
            continue
        publishers[connection.id] = node.create_publisher(
            kind, connection.topic, _recorded_qos(connection)
        )
    return publishers


def _recorded_qos(connection: Connection) -> QoSProfile:
    """Return the QoS that the bag remembers; reliable where it remembers none."""
    offered: list[Any] = getattr(connection.ext, 'offered_qos_profiles', None) or []
    if not offered:
        return RESULT
    keep_all = offered[0].history.name == 'KEEP_ALL'
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if keep_all else HistoryPolicy.KEEP_LAST,
        # A subscriber is known here before it listens: what it asks for again must still be held.
        depth=max(int(offered[0].depth), min(connection.msgcount, LONGEST_QUEUE)),
        reliability=(
            ReliabilityPolicy.BEST_EFFORT
            if offered[0].reliability.name == 'BEST_EFFORT'
            else ReliabilityPolicy.RELIABLE
        ),
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL
            if offered[0].durability.name == 'TRANSIENT_LOCAL'
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
    reader: AnyReader,
    connections: list[Connection],
    publishers: dict[int, Publisher],
    clock: Publisher | None,
    rate: float,
) -> None:
    """Publish the serialized messages, each at its time."""
    first_ns = reader.start_time
    clock_ns = first_ns
    began = time.monotonic()
    # The bar goes to the standard error: the standard output stays free for pipes.
    with Progress(console=Console(stderr=True)) as progress:
        total = sum(connection.msgcount for connection in connections)
        task = progress.add_task('replay', total=total)
        for connection, stamp_ns, data in reader.messages(connections):
            while clock is not None and clock_ns < stamp_ns:
                _sleep_until(began + (clock_ns - first_ns) / 1e9 / rate)
                clock.publish(Clock(clock=from_ns(clock_ns)))
                clock_ns += CLOCK_STEP_NS
            _sleep_until(began + (stamp_ns - first_ns) / 1e9 / rate)
            if clock is not None:
                clock.publish(Clock(clock=from_ns(stamp_ns)))
            if connection.id in publishers:
                publishers[connection.id].publish(bytes(data))
            progress.advance(task)
    for publisher in publishers.values():
        publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=LAST_WORDS))


def _sleep_until(moment: float) -> None:
    """Sleep until a moment of the monotonic clock."""
    pause = moment - time.monotonic()
    if pause > 0.0:
        time.sleep(pause)
    if not rclpy.ok():
        raise ExternalShutdownException

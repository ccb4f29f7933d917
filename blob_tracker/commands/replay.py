"""Publish the messages of a rosbag2 bag, mcap or sqlite3, at the pace at which they came."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
import sys
import time

from blob_tracker.ros.bags import Bag, opened, READABLE, RecordingError, Topic
from blob_tracker.ros.diagnostics.connections import disagreements, full_name
from blob_tracker.ros.endpoints.qos import RESULT, TF_STATIC
from blob_tracker.ros.endpoints.recording import (
    COMPRESSED, IMAGE, image_topic, IMAGES, info_name, info_topic, USUAL,
)
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.process import shut_down
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.validate_full_topic_name import validate_full_topic_name
from rich.console import Console
from rich.progress import Progress
from rosgraph_msgs.msg import Clock

QUIET = 1.0  # s without a new subscriber: all that were starting have been found
# Where a pipeline takes its images, and what it is told to take them.
PIPELINE = {IMAGE: USUAL, COMPRESSED: f'{USUAL}/compressed'}
TRANSPORT = {IMAGE: 'raw', COMPRESSED: 'compressed'}
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
        '--nodes', nargs='+', default=[], metavar='NODE',
        help='wait for these as well: by name, or with namespace as /left/segmenter',
    )
    parser.add_argument(
        '--topics', nargs='+', metavar='TOPIC', help='play these alone; without it all of the bag'
    )
    parser.add_argument(
        '--remap', nargs='+', default=[], type=_rule, metavar='FROM:=TO',
        help='play topics of the bag under other names',
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
        0 when all is published, 1 where the bag cannot be read, has not what it promises, nobody
        takes it, or the nodes of `--nodes` do not come, 2 for a wrong option, 130 after Ctrl-C.

    """
    if not arguments.rate > 0.0:
        print(f'--rate is {arguments.rate}; it must be above 0', file=sys.stderr)
        return 2
    try:
        with opened(arguments.bag) as bag:
            if bag.remark:
                print(bag.remark, file=sys.stderr)
            names = _names(bag, arguments.remap)
            topics = _chosen(bag, names, arguments.topics)
            rclpy.init()
            node = rclpy.create_node('replay')
            try:
                stage = _Stage(node, bag, topics, names)
                clock = node.create_publisher(Clock, '/clock', RESULT) if arguments.clock else None
                missing = _await(node, arguments.nodes, stage, arguments.wait)
                if missing:
                    reason = (
                        f'{", ".join(sorted(missing))} of --nodes did not come '
                        f'within {arguments.wait:g} s; start them, or raise --wait'
                    )
                else:
                    reason = '' if stage.is_heard else stage.why_unheard(arguments.wait)
                if reason:
                    print(f'nothing is played: {reason}', file=sys.stderr)
                    return 1
                _play(bag, topics, stage.publishers, clock, arguments.rate)
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


def _rule(text: str) -> tuple[str, str]:
    """Return both names of FROM:=TO, in full."""
    old, separator, new = text.partition(':=')
    if not separator:
        raise argparse.ArgumentTypeError(f'{text} is not of the form FROM:=TO')
    names = _full(old), _full(new)
    try:
        for name in names:
            validate_full_topic_name(name)
    except InvalidTopicNameException as error:
        raise argparse.ArgumentTypeError(f'{text}: {error}') from None
    return names


def _full(name: str) -> str:
    return f'/{name.strip("/")}'


def _listed(names: Iterable[str]) -> str:
    return ', '.join(sorted(names))


def _names(bag: Bag, rules: Sequence[tuple[str, str]]) -> dict[Topic, str]:
    """Return the name under which each topic of the bag is played."""
    renamed = dict(rules)
    names = {topic: renamed.pop(_full(topic.name), _full(topic.name)) for topic in bag.topics}
    there = _listed(topic.name for topic in bag.topics)
    if renamed:
        raise RecordingError(
            f'--remap: {bag.path} has no {_listed(renamed)}; its topics are {there}'
        )
    if len(set(names.values())) < len(names):
        raise RecordingError(f'--remap gives two topics one name; the topics are {there}')
    return names


def _chosen(
    bag: Bag, names: Mapping[Topic, str], asked: Sequence[str] | None
) -> dict[Topic, int]:
    """Return the topics to play, by either of their names, and how many messages each has."""
    if asked is None:
        chosen = set(bag.topics)
    else:
        wanted = {_full(name) for name in asked}
        there = {name for each in names for name in (names[each], _full(each.name))}
        chosen = {each for each, name in names.items() if {name, _full(each.name)} & wanted}
        strange = wanted - there
        if _full(USUAL) in wanted and _full(USUAL) not in names.values():
            lone = _lone_images(bag)  # which may be compressed
            chosen.update(lone)
            if lone:
                strange.difference_update(_usual_names())
        if strange and chosen:
            print(
                f'--topics: {bag.path} has no {_listed(strange)}; its topics are '
                f'{_listed(topic.name for topic in bag.topics)}',
                file=sys.stderr,
            )
    topics = {topic: count for topic, count in bag.topics.items() if topic in chosen}
    if not any(topics.values()):
        images = [names[each] for each in bag.topics if each.kind == IMAGE]
        hint = f'; --remap {images[0]}:=/{USUAL}, say' if images and asked else ''
        raise RecordingError(
            f'{bag.path} holds no messages of {_listed(asked or names.values())}; '
            f'its topics are {_listed(topic.name for topic in bag.topics)}{hint}'
        )
    return topics


def _usual_names() -> set[str]:
    """Return the topics on which nodes take images and their camera_info."""
    images = {kind: _full(name) for kind, name in PIPELINE.items()}
    return {*images.values(), info_name(images[IMAGE], IMAGE)}


def _lone_images(bag: Bag) -> list[Topic]:
    """Return the only topic of images, and that of its camera_info; empty if there are several."""
    try:
        images = image_topic(bag)
    except RecordingError:
        return []
    infos = info_topic(bag, images)
    return [images] if infos is None else [images, infos]


class _Stage:
    """
    The publishers of a bag, and who listens to them.

    Parameters
    ----------
    node : Node
        Publishes.
    bag : Bag
        Open.
    topics : mapping
        Topics that are played, and how many messages each has.
    names : mapping
        The name of each.

    """

    def __init__(
        self, node: Node, bag: Bag, topics: Mapping[Topic, int], names: Mapping[Topic, str]
    ) -> None:
        self._node = node
        self._bag = bag
        self._topics = topics
        self._names = dict(names)
        self.publishers: dict[Topic, Publisher] = {}
        for topic in topics:
            self._advertise(topic)

    def _advertise(self, topic: Topic) -> None:
        """Have a publisher of a topic, if its messages are known here."""
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
            return
        self.publishers[topic] = self._node.create_publisher(
            kind, self._names[topic], _offered_qos(topic, self._topics[topic])
        )

    @property
    def subscribers(self) -> int:
        """Return how many subscriptions take what is played."""
        return sum(each.get_subscription_count() for each in self.publishers.values())

    @property
    def _unheard_images(self) -> list[Topic]:
        """Return the topics of images, if nobody takes any of them."""
        images = [each for each in self.publishers if each.kind in IMAGES]
        if any(self.publishers[each].get_subscription_count() for each in images):
            return []
        return images

    @property
    def is_heard(self) -> bool:
        """Tell whether somebody takes it, and no pipeline waits for images on another topic."""
        return bool(self.subscribers) and not (self._unheard_images and self._pipelines())

    def _awaited(self) -> list[tuple[str, str]]:
        """Return the topics on which images are awaited and nobody publishes any, with kinds."""
        return sorted(
            (name, kind) for name, kinds in self._node.get_topic_names_and_types()
            for kind in IMAGES if kind in kinds and self._node.count_subscribers(name)
            and not self._node.count_publishers(name)
        )

    def _pipelines(self) -> list[tuple[str, str]]:
        """Return those of them on which a pipeline takes its images."""
        return [
            (name, kind) for name, kind in self._awaited() if name.endswith(f'/{PIPELINE[kind]}')
        ]

    def take_lone_images(self) -> bool:
        """Play the only images of the bag to the only pipeline that waits; tell whether so."""
        lone = _lone_images(self._bag)
        pipelines = [name for name, kind in self._pipelines() if lone and kind == lone[0].kind]
        if len(pipelines) != 1 or self._unheard_images != lone[:1]:
            return False
        for topic, name in self._moved(lone, pipelines[0]):
            if topic in self.publishers and name not in self._names.values():
                print(
                    f'{self._names[topic]} is played as {name}: no other images are in the bag',
                    file=sys.stderr,
                )
                self._node.destroy_publisher(self.publishers.pop(topic))
                self._names[topic] = name
                self._advertise(topic)
        return True

    @staticmethod
    def _moved(topics: Sequence[Topic], name: str) -> list[tuple[Topic, str]]:
        """Return images and their camera_info with their names if the images have this one."""
        return list(zip(topics, (name, info_name(name, topics[0].kind))))

    def why_unheard(self, waited: float) -> str:
        """Return why nobody takes what is offered after so many seconds, and what to do."""
        images = self._unheard_images
        unheard = images if self.subscribers else list(self.publishers)
        reasons = [
            f'nobody takes {_listed(self._names[each] for each in unheard)} within {waited:g} s'
        ]
        for topic in unheard:
            name = self._names[topic]
            offered = _offered_qos(topic, self._topics[topic])
            for end in self._node.get_subscriptions_info_by_topic(name):
                if end.topic_type != topic.kind:
                    reasons.append(f'{full_name(end)} takes {end.topic_type} on {name}')
                reasons += [
                    f'{full_name(end)} asks for {asked} on {name}, which is offered {ours}'
                    for _, ours, asked in disagreements(offered, end.qos_profile)
                ]
        awaited = self._awaited()
        for topic in images:
            infos = info_topic(self._bag, topic)
            topics = [topic] if infos is None else [topic, infos]
            for name, kind in awaited:
                takers = _listed({
                    full_name(each) for each in self._node.get_subscriptions_info_by_topic(name)
                })
                if kind != topic.kind:
                    reasons.append(
                        f'{takers} takes {kind} of {name}, and {topic.name} is {topic.kind}: '
                        f'set image_transport: {TRANSPORT[topic.kind]}'
                    )
                    continue
                rules = ' '.join(
                    f'{self._names[each]}:={new}' for each, new in self._moved(topics, name)
                )
                reasons.append(f'{takers} takes images of {name}: --remap {rules}')
        if len(reasons) == 1:
            reasons.append('start what takes it, or raise --wait')
        return '; '.join(reasons)


def _offered_qos(topic: Topic, count: int) -> QoSProfile:
    """Return the QoS that the bag remembers, but reliable: that serves best effort as well."""
    if not topic.qos:
        return TF_STATIC if topic.name.rpartition('/')[2] == 'tf_static' else RESULT
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
        reliability=ReliabilityPolicy.RELIABLE,
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL
            if offered.get('durability') in ('1', 'transient_local')
            else DurabilityPolicy.VOLATILE
        ),
    )


def _await(
    node: Node, awaited: Iterable[str], stage: _Stage, longest: float
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
        absent = missing_nodes(awaited, node.get_node_names_and_namespaces())
        if stage.subscribers != known or absent != missing:
            known, missing, changed = stage.subscribers, absent, time.monotonic()
        if not missing and time.monotonic() - changed >= QUIET:
            if stage.take_lone_images():
                changed = time.monotonic()
            elif stage.is_heard:
                return set()
        time.sleep(0.05)
    return missing


def missing_nodes(
    awaited: Iterable[str], there: Collection[tuple[str, str]]
) -> set[str]:
    """
    Return which nodes are not there.

    Parameters
    ----------
    awaited : iterable of str
        Their names; one with a / in it is a full name, and is in that namespace alone.
    there : collection of (str, str)
        Name and namespace of each node of the graph.

    """
    known = {name for name, _ in there}
    full = {f'{namespace.rstrip("/")}/{name}' for name, namespace in there}
    return {
        each for each in awaited if (_full(each) not in full if '/' in each else each not in known)
    }


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

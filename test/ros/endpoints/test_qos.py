"""Overrides change the topic that they name, in the way that was asked for, or are refused."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import time

from blob_tracker.ros.endpoints.qos import (
    ASK_NS, IMAGE_IN, IMAGE_OUT, publisher, RESULT, subscription,
)
from blob_tracker.ros.errors import ParameterError
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, ReliabilityPolicy
from rclpy.task import Future
from sensor_msgs.msg import Image


@contextmanager
def node_with(domain: int, **overrides: object) -> Iterator[Node]:
    """Make a node that is given overrides at its start, `a__b` for a.b."""
    arguments = ['--ros-args']
    for name, value in overrides.items():
        arguments += ['-p', f'qos_overrides./frames.{name.replace("__", ".")}:={value}']
    context = Context()
    rclpy.init(args=arguments, context=context, domain_id=domain)
    node = Node('own', context=context)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def test_an_override_changes_its_topic_and_no_other(domain: int) -> None:
    """The profiles are shared by many topics, and rclpy writes into what it is given."""
    with node_with(
        domain, publisher__history='keep_all', publisher__depth=3,
        publisher__durability='transient_local', subscription__reliability='reliable',
    ) as node:
        frames = publisher(node, Image, 'frames', IMAGE_OUT)
        others = publisher(node, Image, 'others', IMAGE_OUT)
        heard = subscription(node, Image, 'frames', lambda image: None, IMAGE_IN)
        also = subscription(node, Image, 'others', lambda image: None, IMAGE_IN)
        assert frames.qos_profile.history == HistoryPolicy.KEEP_ALL
        assert frames.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        assert heard.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        assert others.qos_profile.history == HistoryPolicy.KEEP_LAST
        assert others.qos_profile.depth == 10
        assert also.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
        assert node.get_parameter('qos_overrides./frames.publisher.depth').value == 3
        # Who comes later is given the last ones of what is latched: it is published to nobody.
        assert frames.is_wanted
        assert not publisher(node, Image, 'nobody', IMAGE_OUT).is_wanted


def test_an_override_of_the_only_light_is_for_those_with_names_too(domain: int) -> None:
    """Unless there is another for one of them; topics that only begin alike are left alone."""
    given = {
        '/target/ray.publisher.history': 'keep_all', '/target/ray.publisher.depth': 30,
        '/target/port/ray.publisher.depth': 20,
    }
    arguments = [word for name, value in given.items()
                 for word in ('-p', f'qos_overrides.{name}:={value}')]
    context = Context()
    rclpy.init(args=['--ros-args', *arguments], context=context, domain_id=domain)
    node = Node('own', context=context)
    try:
        profiles = {
            topic: publisher(node, Image, topic, RESULT).qos_profile
            for topic in ('target/port/ray', 'target/mast/ray', 'target/mast/bearing')
        }
        port, mast, bearing = profiles.values()
        assert (port.history, port.depth) == (HistoryPolicy.KEEP_ALL, 20)
        assert (mast.history, mast.depth) == (HistoryPolicy.KEEP_ALL, 30)
        assert (bearing.history, bearing.depth) == (RESULT.history, RESULT.depth)
        assert node.get_parameter(
            'qos_overrides./target/mast/ray.publisher.history').value == 'keep_all'
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def test_whether_anybody_listens_is_known_soon_after_it_changes(
    domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is asked again after `ASK_NS`, not with each frame."""
    with node_with(domain) as node:
        frames = publisher(node, Image, 'frames', IMAGE_OUT)
        now_ns, asked = [10**9], []
        count = frames.get_subscription_count
        monkeypatch.setattr(time, 'monotonic_ns', lambda: now_ns[0])
        monkeypatch.setattr(
            frames, 'get_subscription_count', lambda: asked.append(now_ns[0]) or count())
        assert not frames.is_wanted and not frames.is_wanted
        assert len(asked) == 1
        subscription(node, Image, 'frames', lambda image: None, IMAGE_IN)
        while not count():
            pass  # until the two have met
        assert not frames.is_wanted
        now_ns[0] += ASK_NS
        assert frames.is_wanted and frames.is_wanted
        assert len(asked) == 2


@pytest.mark.parametrize('overrides, sentence', [
    ({'publisher__reliability': 'magic'},
     "'qos_overrides./frames.publisher.reliability' is 'magic'; it must be one of system_default, "
     'reliable, best_effort'),
    ({'publisher__depth': 0}, "publisher.depth' is 0; it must be an integer from 1 to"),
    ({'publisher__depth': 'ten'}, "publisher.depth' is 'ten'; it must be an integer"),
    ({'publisher__history': True}, "publisher.history' is True; it must be one of"),
    ({'publisher__reliabilty': 'reliable'},
     "no parameter 'qos_overrides./frames.publisher.reliabilty'; what can be overridden is "
     'history, depth, reliability, durability'),
])
def test_an_impossible_override_is_refused(
    overrides: dict[str, object], sentence: str, domain: int
) -> None:
    """With the name of the parameter, its value and what would be right."""
    with node_with(domain, **overrides) as node:
        with pytest.raises(ParameterError, match='qos_overrides') as raised:
            publisher(node, Image, 'frames', IMAGE_OUT)
    assert sentence in str(raised.value)


@pytest.mark.parametrize('make', [SingleThreadedExecutor, EventsExecutor])
def test_a_message_comes_with_what_the_middleware_says_of_it(
    make: type[Executor], domain: int
) -> None:
    """In either executor, of which one hands them over in another way."""
    with node_with(domain) as node:
        numbers: list[int] = []
        done = Future()

        def take(message: Image, information: dict[str, int]) -> None:
            numbers.append(information['publication_sequence_number'])
            if len(numbers) == 3:
                done.set_result(None)

        subscription(node, Image, 'frames', take, IMAGE_IN, lambda event: None)
        images = publisher(node, Image, 'frames', IMAGE_OUT)
        node.create_timer(0.05, lambda: images.publish(Image()))
        executor = make(context=node.context)
        executor.add_node(node)
        executor.spin_until_future_complete(done, 20.0)
        executor.shutdown()
    first = numbers[0]
    assert numbers == [first, first + 1, first + 2]


@pytest.mark.parametrize('make', [SingleThreadedExecutor, EventsExecutor])
def test_what_is_published_after_the_end_goes_nowhere_without_a_trace(
    make: type[Executor], domain: int, capfd: pytest.CaptureFixture[str]
) -> None:
    """A signal ends the context in the midst of a callback: neither an error nor a word."""
    said: list[int] = []
    with node_with(domain) as node:
        frames = publisher(node, Image, 'frames', IMAGE_OUT)

        def publish() -> None:
            frames.publish(Image())
            said.append(1)
            node.context.shutdown()
            frames.publish(Image())
            said.append(frames.get_subscription_count())

        node.create_timer(0.01, publish)
        executor = make(context=node.context)
        executor.add_node(node)
        with suppress(ExternalShutdownException):
            executor.spin_until_future_complete(Future(), 5.0)
        executor.shutdown()
    assert said == [1, 0]
    assert 'Traceback' not in capfd.readouterr().err


def test_what_cannot_be_published_is_still_an_error(domain: int) -> None:
    """While ROS is there nothing is swallowed."""
    with node_with(domain) as node:
        frames = publisher(node, Image, 'frames', IMAGE_OUT)
        with pytest.raises(TypeError):
            frames.publish('no image')
        frames.destroy()
        with pytest.raises(RuntimeError, match='Destroyable'):
            frames.publish(Image())
        assert node.context.ok()

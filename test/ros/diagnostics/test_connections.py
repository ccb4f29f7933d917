"""Why two ends of a topic do not understand each other, with names and what would be right."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.connections import (
    Connections, disagreements, full_name, unheard, unhearing,
)
from blob_tracker.ros.diagnostics.health import Health, PATIENCE
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosgraph_msgs.msg import Clock
from support.processes import probe


def profile(
    reliability: str = 'RELIABLE', durability: str = 'VOLATILE', deadline: float = 1e9,
    liveliness: str = 'AUTOMATIC',
) -> QoSProfile:
    """Return a profile with all policies set, as those of the graph are."""
    return QoSProfile(
        depth=1,
        reliability=ReliabilityPolicy[reliability],
        durability=DurabilityPolicy[durability],
        deadline=Duration(seconds=deadline),
        liveliness=LivelinessPolicy[liveliness],
        liveliness_lease_duration=Duration(seconds=1e9),
    )


def endpoint(
    name: str, qos: QoSProfile, kind: str = 'sensor_msgs/msg/Image', namespace: str = '/'
) -> TopicEndpointInfo:
    """Return an endpoint of the graph."""
    return TopicEndpointInfo(
        node_name=name, node_namespace=namespace, topic_type=kind, qos_profile=qos
    )


def test_those_who_understand_each_other_are_not_named() -> None:
    """More may be offered than is asked for."""
    for offered, asked in (
        (profile(), profile()),
        (profile(), profile('BEST_EFFORT')),
        (profile('RELIABLE', 'TRANSIENT_LOCAL'), profile('BEST_EFFORT', 'VOLATILE')),
        (profile(deadline=0.1), profile(deadline=1.0)),
        (profile(liveliness='MANUAL_BY_TOPIC'), profile()),
    ):
        assert disagreements(offered, asked) == []


@pytest.mark.parametrize('offered, asked, expected', [
    (profile('BEST_EFFORT'), profile(), [('reliability', 'best_effort', 'reliable')]),
    (profile(), profile('RELIABLE', 'TRANSIENT_LOCAL'),
     [('durability', 'volatile', 'transient_local')]),
    (profile('BEST_EFFORT'), profile('RELIABLE', 'TRANSIENT_LOCAL'),
     [('reliability', 'best_effort', 'reliable'), ('durability', 'volatile', 'transient_local')]),
    (profile(deadline=2.0), profile(deadline=0.5), [('deadline', '2 s', '0.5 s')]),
    (profile(), profile(liveliness='MANUAL_BY_TOPIC'),
     [('liveliness', 'automatic', 'manual_by_topic')]),
])
def test_each_policy_is_named(
    offered: QoSProfile, asked: QoSProfile, expected: list[tuple[str, str, str]]
) -> None:
    """And no other: what is offered beyond what is asked for is no disagreement."""
    assert disagreements(offered, asked) == expected


def test_the_sentences_say_who_and_what_to_do() -> None:
    """From both ends; an override is offered where there is one."""
    ours = endpoint('segmenter', profile(), namespace='/left')
    driver = endpoint('driver', profile('BEST_EFFORT'), namespace='/left')
    assert unheard('/left/camera/image_raw', ours, driver) == (
        '/left/camera/image_raw: /left/driver publishes best_effort and this node asks for '
        'reliable, so that nothing arrives from it; set its reliability to reliable, or '
        'qos_overrides./left/camera/image_raw.subscription.reliability of this node to best_effort'
    )
    servo = endpoint('servo', profile('RELIABLE', 'TRANSIENT_LOCAL'))
    assert unhearing('/target/bearing', ours, servo) == (
        '/target/bearing: /servo asks for transient_local and this node publishes volatile, so '
        'that it hears nothing; set its durability to volatile, or '
        'qos_overrides./target/bearing.publisher.durability of this node to transient_local'
    )
    late = endpoint('servo', profile(deadline=0.1))
    assert unhearing('/target/bearing', ours, late).endswith('; set its deadline to 1e+09 s')


def test_another_type_is_named() -> None:
    """It is the first thing that is wrong: the policies do not matter then."""
    ours = endpoint('segmenter', profile())
    other = endpoint('driver', profile('BEST_EFFORT'), 'sensor_msgs/msg/CompressedImage')
    assert unheard('/camera/image_raw', ours, other) == (
        '/camera/image_raw: /driver publishes sensor_msgs/msg/CompressedImage there and this node '
        'takes sensor_msgs/msg/Image; remap one of the two'
    )
    assert 'takes sensor_msgs/msg/CompressedImage there and this node publishes' in unhearing(
        '/camera/image_raw', ours, other
    )


def test_what_has_no_name_is_said_to_have_none() -> None:
    """A participant of DDS that is no node of ROS."""
    assert full_name(endpoint('_NODE_NAME_UNKNOWN_', profile(), namespace='_NODE_NAMESPACE_')) == (
        'a node without a name'
    )


def test_a_clock_that_stopped_is_told_from_one_that_never_was(domain: int) -> None:
    """The bag was played with --clock; that it has ended is all that is wrong then."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        node.set_parameters([Parameter('use_sim_time', value=True)])
        Connections(node, Health(node, 'is there a camera?'))

        def says(words: str) -> bool:
            return bool(heard) and words in heard[-1].status[0].message

        node.spin_until(lambda: says('is true and nothing publishes /clock'))
        assert [each.status[0].message for each in heard[:PATIENCE]] == ['waiting'] * PATIENCE
        clock = node.create_publisher(Clock, '/clock', 10)
        node.spin_until(
            lambda: clock.publish(Clock(clock=Time(sec=7))) or node.get_clock().now().nanoseconds
        )
        node.destroy_publisher(clock)
        node.spin_until(lambda: says('/clock has stopped at 7.000 s'))
        assert not says('--clock') and not says('camera')

"""/tf and /tf_static as other nodes publish them, into a tree; what is wrong with them is said."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
import time
from types import SimpleNamespace

from blob_tracker.ros.endpoints.transforms import angle_between, TransformBroadcaster, Transforms
from blob_tracker.ros.messages.transform import transform_message
from blob_tracker.transforms import NoTransform, Transform
import numpy as np
import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rosbags.typesys import get_typestore, Stores
from scipy.spatial.transform import Rotation
from support.processes import Probe, probe
from support.transforms import Broadcaster, transform

pytestmark = pytest.mark.usefixtures('tf2_messages')

MS = 1_000_000
NOW = 1_700_000_000_000 * MS


class Heard:
    """A node of its own with transforms, and a probe that publishes them."""

    def __init__(self, node: Probe, own: Node, tf: Broadcaster) -> None:
        self.node, self.own, self.tf = node, own, tf
        self.faults: list[str] = []
        self.came = 0
        health = SimpleNamespace(
            fault=lambda level, words: self.faults.append(words), count=lambda name: None
        )
        self.transforms = Transforms(
            own, health, self._came, nullcontext(), hold=0.2,  # type: ignore[arg-type]
            asked_by='use_tf',
        )

    def _came(self) -> None:
        self.came += 1

    def wait(self, count: int) -> None:
        """Wait until so many messages have come."""
        self.node.spin_until(lambda: self.came >= count)


@pytest.fixture
def heard(domain: int, tf2_messages: None) -> Iterator[Heard]:
    """Make one that hears of two frames, one of which was said before it came."""
    with probe(domain) as node:
        tf = Broadcaster(node)
        tf.hold(camera=('pan', transform(x=1.0)))
        own = Node('own', context=node.context)
        node._spinner.add_node(own)
        made = Heard(node, own, tf)
        node.spin_until(lambda: tf.moving.get_subscription_count())
        tf.move(NOW, pan=('base', transform(yaw=0.1)))
        tf.move(NOW + 10 * MS, pan=('base', transform(yaw=0.2)))
        made.wait(3)
        yield made
        node._spinner.remove_node(own)
        own.destroy_node()


def test_a_frame_that_two_nodes_publish_is_named(heard: Heard) -> None:
    """With the same parent; what each of them says of other frames is all right."""
    other = Broadcaster(heard.node)
    heard.node.spin_until(lambda: other.moving.get_subscription_count())
    for number in range(3):
        heard.tf.move(NOW + (30 + 20 * number) * MS, pan=('base', transform(yaw=0.3)))
        other.move(NOW + (40 + 20 * number) * MS, arm=('base', transform(yaw=0.3)))
    heard.wait(9)
    assert not heard.faults
    for number in range(3):
        heard.tf.move(NOW + (100 + 20 * number) * MS, pan=('base', transform(yaw=0.3)))
        heard.wait(10 + 2 * number)
        other.move(NOW + (110 + 20 * number) * MS, pan=('base', transform(yaw=0.9)))
        heard.wait(11 + 2 * number)
    assert any("several nodes publish 'pan' on /tf" in each for each in heard.faults)
    assert not any("'arm'" in each for each in heard.faults)


def test_what_comes_is_looked_up(heard: Heard) -> None:
    """Also what was published for good before."""
    found = heard.transforms.lookup('camera', 'base', NOW + 5 * MS)
    np.testing.assert_allclose(
        Rotation.from_matrix(found.transform.matrix).as_euler('xyz'), [0.0, 0.0, 0.15], atol=1e-12
    )
    assert heard.transforms.fixed('camera', 'pan').translation == (1.0, 0.0, 0.0)
    assert not heard.faults
    heard.transforms.forget(NOW)
    with pytest.raises(NoTransform):
        heard.transforms.lookup('camera', 'base', NOW + 5 * MS)


def test_the_quality_of_service_is_that_of_tf2_ros(heard: Heard) -> None:
    """So that the nodes of others match, and what was said before is heard."""
    for topic, durability in (
        ('/tf', DurabilityPolicy.VOLATILE), ('/tf_static', DurabilityPolicy.TRANSIENT_LOCAL)
    ):
        profile, = (
            each.qos_profile for each in heard.own.get_subscriptions_info_by_topic(topic)
        )
        assert (profile.durability, profile.reliability) == (
            durability, ReliabilityPolicy.RELIABLE)


def test_what_cannot_be_is_refused_and_remembered(heard: Heard) -> None:
    """A static one is said once: why it was refused is told with what is missing for it."""
    heard.tf.hold(imu=('base', Transform(rotation=(0.0, 0.0, 0.0, 0.5))))
    heard.wait(4)
    heard.tf.move(0, wheel=('base', Transform()))
    heard.wait(5)
    assert heard.faults == [
        "TF: the transform of 'imu' in 'base': its quaternion (0, 0, 0, 0.5) has the length 0.5; "
        'it must have the length 1',
        "TF: the transform of 'wheel' in 'base': it has no stamp; on /tf each must have that of "
        'its instant',
    ]
    with pytest.raises(NoTransform) as raised:
        heard.transforms.lookup('imu', 'base', NOW)
    words = heard.transforms.explain(raised.value)
    assert "nothing was said of 'imu'" in words
    assert "refused was: the transform of 'imu' in 'base': its quaternion" in words
    heard.tf.hold(imu=('base', Transform()))
    heard.wait(6)
    assert heard.transforms.fixed('imu', 'base') == Transform()


def test_a_clock_that_is_another_one_is_told_from_a_publisher_that_stopped(
    heard: Heard, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By whether they come all the time."""
    with pytest.raises(NoTransform) as raised:
        heard.transforms.lookup('camera', 'base', NOW + 5000 * MS)
    assert 'are of another clock' in heard.transforms.explain(raised.value)
    later_ns = time.monotonic_ns() + 2000 * MS
    monkeypatch.setattr(time, 'monotonic_ns', lambda: later_ns)
    assert 'is their publisher still running?' in heard.transforms.explain(raised.value)


def test_stamps_that_jump_back_are_told(heard: Heard) -> None:
    """And what comes from then on counts."""
    heard.tf.move(NOW - 60_000 * MS, pan=('base', transform(yaw=0.3)))
    heard.wait(4)
    assert heard.faults == ["/tf: the stamps of 'pan' jumped back by 60.010 s; starting again"]
    assert heard.transforms.lookup('pan', 'base', NOW - 60_000 * MS)


def test_what_is_broadcast_comes_back(heard: Heard) -> None:
    """On /tf, to whoever listens."""
    broadcaster = TransformBroadcaster(heard.own, 'publish_tf')
    heard.node.spin_until(lambda: broadcaster._publisher.get_subscription_count())
    broadcaster.send([transform_message(transform(y=2.0), 'body', 'camera', NOW)])
    heard.wait(4)
    found = heard.transforms.lookup('body', 'camera', NOW).transform
    assert found.translation == (0.0, 2.0, 0.0)


def test_the_messages_are_those_of_ros(heard: Heard) -> None:
    """By the hash of the type, that each publisher tells."""
    types = get_typestore(Stores.ROS2_JAZZY)
    published = heard.node.get_publishers_info_by_topic('/tf')
    assert {str(each.topic_type_hash) for each in published} == {
        types.hash_rihs01('tf2_msgs/msg/TFMessage')}


@pytest.mark.parametrize('angle', [0.0, 1e-9, 1e-4, 0.5, 3.0])
def test_the_angle_between_two_turns(angle: float) -> None:
    """Also of small ones."""
    one = Rotation.from_rotvec([0.4, -1.0, 0.2])
    other = one * Rotation.from_rotvec(angle * np.array([0.6, 0.0, 0.8]))
    found = angle_between(one.as_matrix(), other.as_matrix())
    assert found == pytest.approx(angle, rel=1e-6, abs=1e-15)

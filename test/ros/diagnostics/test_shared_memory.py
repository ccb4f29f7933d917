"""What there is of a process' shared memory, and which process an endpoint belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys

from blob_tracker.resources import config_path
from blob_tracker.ros.diagnostics.shared_memory import (
    barrier, DEFAULT_BYTES, export, same_host, segment_size, VARIABLE,
)
import pytest
from rclpy.topic_endpoint_info import TopicEndpointInfo
from std_msgs.msg import Bool
from support.processes import Probe, probe, Process

PUBLISHER = """
import rclpy
from std_msgs.msg import Bool
rclpy.init()
node = rclpy.create_node('other')
node.create_publisher(Bool, 'a', 1)
rclpy.spin(node)
"""


def publishers(node: Probe) -> Sequence[TopicEndpointInfo]:
    """Wait for those of the topic."""
    node.spin_until(lambda: node.get_publishers_info_by_topic('a'))
    return node.get_publishers_info_by_topic('a')


@pytest.mark.parametrize('word, least, most', [
    ('segment_size', 32 << 20, 34 << 20),  # of bytes, and descriptors of them
    ('segmentsize', DEFAULT_BYTES, 2 * DEFAULT_BYTES),
])
def test_the_segment_that_there_is_counts(
    word: str, least: int, most: int, domain: int, tmp_path: Path
) -> None:
    """Not what a profile asks for: with a word that Fast DDS does not know it is dropped whole."""
    profile = tmp_path / 'profile.xml'
    profile.write_text(config_path('fastdds.xml').read_text().replace('segment_size', word))
    command = ['env', f'{VARIABLE}={profile}', sys.executable, '-c', PUBLISHER]
    with probe(domain) as node, Process(command, domain):
        size = segment_size(bytes(publishers(node)[0].endpoint_gid))
    assert size is not None and least <= size < most


def test_the_line_to_type() -> None:
    """It names the profile of the package."""
    assert export() == f'export {VARIABLE}={config_path("fastdds.xml")}'


def test_an_endpoint_tells_its_process(domain: int) -> None:
    """Its GUID has the machine and the process id: here this very process'."""
    with probe(domain) as node:
        node.create_publisher(Bool, 'a', 1)
        node.create_subscription(Bool, 'a', lambda message: None, 1)
        node.spin_until(lambda: node.get_subscriptions_info_by_topic('a'))
        gid = bytes(publishers(node)[0].endpoint_gid)
        other = bytes(node.get_subscriptions_info_by_topic('a')[0].endpoint_gid)
        assert segment_size(gid) is not None
        assert barrier(gid) == ''
    assert same_host(gid, other)
    elsewhere = gid[:2] + bytes([gid[2] ^ 1]) + gid[3:]
    assert not same_host(elsewhere, other)


def test_a_process_that_is_not_seen_may_have_ended() -> None:
    """No process has the number 0, and nobody can tell why it is not there."""
    gid = b'\x01\x0f' + bytes(14)
    assert segment_size(gid) is None
    assert barrier(gid).startswith('its process is not visible from here; if it has not ended')


def test_an_endpoint_of_another_middleware_tells_nothing() -> None:
    """Its identifier is of another make."""
    assert segment_size(bytes(16)) is None
    assert same_host(bytes(16), b'\x01\x0f' + bytes(14))

"""Whether a process has the Fast DDS profile, and which process an endpoint belongs to."""

from __future__ import annotations

import os
from pathlib import Path

from blob_tracker.resources import config_path
from blob_tracker.ros.diagnostics.shared_memory import (
    DEFAULT_BYTES, environment_of, export, same_host, segment_size, VARIABLE,
)
from std_msgs.msg import Bool
from support.processes import probe


def test_size_of_the_segment(tmp_path: Path) -> None:
    """That of the profile; Fast DDS' own where there is none that can be read."""
    broken = tmp_path / 'broken.xml'
    broken.write_text('<dds>')
    plain = tmp_path / 'plain.xml'
    plain.write_text('<dds xmlns="http://www.eprosima.com"><profiles/></dds>')
    assert segment_size({VARIABLE: str(config_path('fastdds.xml'))}) == 32 << 20
    for name in ('', '/no/such/file.xml', str(broken), str(plain)):
        assert segment_size({VARIABLE: name}) == DEFAULT_BYTES
    assert segment_size({}) == DEFAULT_BYTES
    assert export() == f'export {VARIABLE}={config_path("fastdds.xml")}'


def test_an_endpoint_tells_its_process(domain: int) -> None:
    """Its GUID has the machine and the process id: here this very process'."""
    with probe(domain) as node:
        node.create_publisher(Bool, 'a', 1)
        node.create_subscription(Bool, 'a', lambda message: None, 1)
        node.spin_until(
            lambda: node.get_publishers_info_by_topic('a')
            and node.get_subscriptions_info_by_topic('a')
        )
        gid = bytes(node.get_publishers_info_by_topic('a')[0].endpoint_gid)
        other = bytes(node.get_subscriptions_info_by_topic('a')[0].endpoint_gid)
    environment = environment_of(gid)
    assert environment is not None
    assert environment['PATH'] == os.environ['PATH']
    assert same_host(gid, other)
    elsewhere = gid[:2] + bytes([gid[2] ^ 1]) + gid[3:]
    assert not same_host(elsewhere, other)


def test_an_endpoint_of_another_middleware_tells_nothing() -> None:
    """Its identifier is of another make."""
    assert environment_of(bytes(16)) is None
    assert same_host(bytes(16), b'\x01\x0f' + bytes(14))

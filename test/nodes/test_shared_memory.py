"""Nodes that Fast DDS matches and whose shared memory is out of each other's reach."""

from __future__ import annotations

import os
import signal
import sys

from blob_tracker.ros.diagnostics.shared_memory import by_network
from diagnostic_msgs.msg import DiagnosticArray
import pytest
from sensor_msgs.msg import CameraInfo
from support.processes import probe, Process, start

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason='only root has other users')

# Loaded before the user changes: he may have no right to the files of Python.
PUBLISHER = """
import os
import sys
import rclpy
from rclpy.type_support import check_for_type_support
from sensor_msgs.msg import CameraInfo
check_for_type_support(CameraInfo)
rclpy.init()
rclpy.create_node('first').destroy_node()
rclpy.shutdown()
os.setgid(int(sys.argv[1]))
os.setuid(int(sys.argv[1]))
rclpy.init(args=['--ros-args', '--disable-external-lib-logs'])
node = rclpy.create_node('driver')
publisher = node.create_publisher(CameraInfo, 'camera/camera_info', 10)
node.create_timer(0.05, lambda: publisher.publish(CameraInfo()))
rclpy.spin(node)
"""
OWN_FOLDER = ['unshare', '--mount', 'sh', '-c', 'mount -t tmpfs t /dev/shm; exec "$@"', 'x']
OWN_PROCESSES = ['unshare', '--mount', '--ipc', '--pid', '--fork', '--kill-child', *OWN_FOLDER]


def driver(domain: int, *before: str, uid: int = 0) -> Process:
    """Start a publisher of camera_info, in other circumstances."""
    return Process([*before, sys.executable, '-c', PUBLISHER, str(uid)], domain)


@pytest.mark.parametrize(
    'before, uid, reason',
    [
        (OWN_FOLDER, 0, 'it has its own /dev/shm'),
        (OWN_PROCESSES, 0, 'a container'),
        ([], 12345, 'it runs as another user (uid 12345, this one 0)'),
    ],
)
def test_who_is_out_of_reach_is_named(
    before: list[str], uid: int, reason: str, domain: int
) -> None:
    """In place of a question whether there is a camera."""
    with probe(domain) as node:
        said = node.record(DiagnosticArray, '/diagnostics')
        with (
            driver(domain, *before, uid=uid) as other, start('segmenter', domain) as segmenter
        ):
            node.spin_until(lambda: any(
                '/camera/camera_info: a publisher is known and nothing comes through shared '
                'memory: ' in status.message and reason in status.message
                for array in said for status in array.status
            ))
            segmenter.end()
            other.end(signal.SIGKILL)  # unshare heeds no Ctrl-C while its child runs
    assert by_network() in segmenter.output


def test_the_remedy_helps(domain: int) -> None:
    """One of the two does without shared memory, and what it publishes arrives."""
    line = f'{by_network()}; exec "$@"'
    with probe(domain) as node:
        infos = node.record(CameraInfo, 'camera/camera_info')
        with driver(domain, *OWN_FOLDER, 'sh', '-c', line, 'x'):
            node.spin_until(lambda: infos)


def test_one_that_publishes_nothing_is_within_reach(domain: int) -> None:
    """Nothing is said of shared memory then."""
    with probe(domain) as node:
        said = node.record(DiagnosticArray, '/diagnostics')
        node.create_publisher(CameraInfo, 'camera/camera_info', 10)
        with start('segmenter', domain):
            node.spin_until(lambda: any(
                'no frames arrive; is a camera publishing' in status.message
                for array in said for status in array.status
            ))
    assert not any('shared memory' in each.status[0].message for each in said)

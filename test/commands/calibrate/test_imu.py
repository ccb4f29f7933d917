"""`calibrate imu` as a user runs it: a bag, what it writes, and what a bag lacks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import sys
import time

from blob_tracker.__main__ import main
from blob_tracker.nodes.interface.tracker import PARAMETERS
from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from sensor_msgs.msg import Imu
from support.bags import START_NS, TYPES
from support.processes import probe, Process
from support.slowness import slowness
from support.turned_imu import BEARING, draw, Drawn
import yaml


def messages_of(drawn: Drawn) -> Iterator[tuple[int, PoseWithCovarianceStamped | Imu]]:
    """Yield what was drawn as messages, in their order, each with its stamp."""
    times, directions, _, ticks, rates = drawn.measured
    bearings = [
        Bearing(
            1e3 * np.arctan2(x, z), 1e3 * np.arcsin(-y), (1e3 * BEARING) ** 2 * np.eye(2),
            START_NS + round(1e9 * at),
        )
        for at, (x, y, z) in zip(times, directions)
    ]
    messages: list[tuple[int, PoseWithCovarianceStamped | Imu]] = [
        (each.stamp_ns, ray_message(each, 'optical')) for each in bearings
    ]
    for at, (x, y, z) in zip(ticks, rates):
        stamp_ns = START_NS + round(1e9 * at)
        message = Imu()
        message.header.stamp, message.header.frame_id = from_ns(stamp_ns), 'imu_link'
        message.angular_velocity = Vector3(x=x, y=y, z=z)
        messages.append((stamp_ns, message))
    yield from sorted(messages, key=lambda each: each[0])


def write_bag(folder: Path, drawn: Drawn, imu: str = '/imu') -> Path:
    """Write what was drawn."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        rays, samples = (
            writer.add_connection(topic, kind, typestore=TYPES) for topic, kind in (
                ('/target/ray', 'geometry_msgs/msg/PoseWithCovarianceStamped'),
                (imu, 'sensor_msgs/msg/Imu'),
            )
        )
        for stamp_ns, message in messages_of(drawn):
            topic = samples if isinstance(message, Imu) else rays
            writer.write(topic, stamp_ns, serialize_message(message))
    return folder


def test_it_writes_what_the_tracker_takes(tmp_path: Path) -> None:
    """The turn, the offset and the bias, by the names of the parameters; and the picture."""
    drawn = draw(7)
    out = tmp_path / 'imu.yaml'
    bag = write_bag(tmp_path / 'bag', drawn)
    assert main(['calibrate', 'imu', str(bag), '--out', str(out)]) == 0
    values = yaml.safe_load(out.read_text())['/**/tracker']['ros__parameters']
    assert values.keys() <= {each.name for each in PARAMETERS}
    turn = turn_of(values['imu.roll'], values['imu.pitch'], values['imu.yaw'])
    np.testing.assert_allclose(turn.T, drawn.turn.as_matrix(), atol=1e-3)
    found = [values[f'imu.{each}'] for each in ('stamp_offset', 'bias_x', 'bias_y', 'bias_z')]
    np.testing.assert_allclose(found, drawn.others[:4], atol=1e-3)
    assert values['imu.enabled'] is True
    assert values['imu.frame_id'] == 'imu_link'
    assert out.with_suffix('.png').stat().st_size > 10_000


def test_live_it_finds_the_same(tmp_path: Path, domain: int) -> None:
    """From another process, 20 s of turning in 2."""
    drawn = draw(7, duration=20.0)
    out = tmp_path / 'imu.yaml'
    command = [sys.executable, '-m', 'blob_tracker', 'calibrate', 'imu', '--out', str(out),
               '--seconds', f'{5.0 * slowness():.1f}']
    with probe(domain) as node, Process(command, domain) as process:
        rays = node.create_publisher(PoseWithCovarianceStamped, 'target/ray', 1000)
        samples = node.create_publisher(Imu, 'imu', 1000)
        node.spin_until(
            lambda: rays.get_subscription_count() and samples.get_subscription_count())
        for count, (_, message) in enumerate(messages_of(drawn)):
            (samples if isinstance(message, Imu) else rays).publish(message)
            if count % 6 == 0:
                time.sleep(0.005)
        assert process.wait(40.0) == 0, process.output
    values = yaml.safe_load(out.read_text())['/**/tracker']['ros__parameters']
    turn = turn_of(values['imu.roll'], values['imu.pitch'], values['imu.yaw'])
    np.testing.assert_allclose(turn.T, drawn.turn.as_matrix(), atol=1e-3)


def test_what_is_wrong_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A bag without the topic; turning that tells nothing: and nothing is written."""
    out = tmp_path / 'imu.yaml'
    other = write_bag(tmp_path / 'other', draw(7, duration=2.0), '/imu/data')
    assert main(['calibrate', 'imu', str(other), '--out', str(out)]) == 1
    assert 'has 0 topics imu of the type sensor_msgs/msg/Imu' in capsys.readouterr().err
    arguments = ['calibrate', 'imu', str(other), '--imu', 'imu/data', '--out', str(out)]
    assert main(arguments) == 1
    assert 'pairs of bearings follow each other' in capsys.readouterr().err
    assert not out.exists()

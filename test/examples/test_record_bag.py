"""The example recorder as a real process: what it kept is read by the commands' own reader."""

from __future__ import annotations

import itertools
from pathlib import Path
import re
import subprocess
import sys

from blob_tracker.ros.endpoints.recording import recorded_frames
from blob_tracker.ros.messages.stamp import from_ns
import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image
from support.processes import probe, Process

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'record_bag.py'
STAMPS = (1_700_000_000_000_000_000 + 33_000_000 * index for index in itertools.count())
ENOUGH = 5


def test_it_records_images_until_ctrl_c(domain: int, tmp_path: Path) -> None:
    """As any driver offers them, best effort; it shows how many it has."""
    bag, shown = tmp_path / 'bag', tmp_path / 'shown'
    sent: list[int] = []
    to_file = ['sh', '-c', 'exec "$@" >shown', 'x']
    command = ['env', '-C', str(tmp_path), *to_file, sys.executable, str(EXAMPLE), str(bag)]
    with probe(domain) as node, Process(command, domain) as made:
        images = node.create_publisher(Image, 'camera/image_raw', qos_profile_sensor_data)
        infos = node.create_publisher(CameraInfo, 'camera/camera_info', qos_profile_sensor_data)
        node.spin_until(infos.get_subscription_count)

        def enough() -> bool:
            sent.append(next(STAMPS))
            image = Image(height=2, width=3, step=3, encoding='mono8', data=bytes(range(6)))
            image.header.stamp = from_ns(sent[-1])
            images.publish(image)
            node.spin(0.02)
            counts = map(int, re.findall(rb'\r(\d+) messages', shown.read_bytes()))
            return max(counts, default=0) >= ENOUGH

        node.spin_until(enough)  # what is sent before it knows who sends is lost
        assert made.end() == 0, made.output
    kept = [frame.stamp_ns for frame, _ in recorded_frames(bag)]
    assert shown.read_bytes().endswith(f'\r{len(kept)} messages in {bag}\n'.encode())
    assert len(kept) >= ENOUGH
    assert kept == [stamp_ns for stamp_ns in sent if stamp_ns in kept]


@pytest.mark.parametrize(('words', 'sentence'), [
    (['old'], 'old exists already'),
    (['new', 'target/ray'], "'' is no type of messages that is installed here; write TOPIC:TYPE"),
    (['new', 'target/ray:geometry_msgs/msg/Poze'], "'geometry_msgs/msg/Poze' is no type"),
    (['new', 'target/ray:no_such_msgs/msg/Pose'], "'no_such_msgs/msg/Pose' is no type"),
])
def test_what_cannot_be_recorded_is_said(
    tmp_path: Path, words: list[str], sentence: str
) -> None:
    """In a sentence after the usage, with nothing written."""
    (tmp_path / 'old').mkdir()
    done = subprocess.run(
        [sys.executable, str(EXAMPLE), *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert sentence in done.stderr and 'Traceback' not in done.stderr
    assert not list(tmp_path.glob('*/*'))

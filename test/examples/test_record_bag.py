"""The example recorder as a real process: what it kept is read by the commands' own reader."""

from __future__ import annotations

from pathlib import Path
import sys

from blob_tracker.ros.endpoints.recording import recorded_frames
from blob_tracker.ros.messages.stamp import from_ns
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image
from support.processes import probe, Process

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'record_bag.py'
STAMPS = [1_700_000_000_000_000_000 + 33_000_000 * index for index in range(5)]


def test_it_records_images_until_ctrl_c(domain: int, tmp_path: Path) -> None:
    """As any driver offers them, best effort."""
    bag = tmp_path / 'bag'
    with probe(domain) as node, Process([sys.executable, str(EXAMPLE), str(bag)], domain) as made:
        images = node.create_publisher(Image, 'camera/image_raw', qos_profile_sensor_data)
        infos = node.create_publisher(CameraInfo, 'camera/camera_info', qos_profile_sensor_data)
        node.spin_until(lambda: images.get_subscription_count() and infos.get_subscription_count())
        for stamp in STAMPS:
            image = Image(height=2, width=3, step=3, encoding='mono8', data=bytes(range(6)))
            image.header.stamp = from_ns(stamp)
            images.publish(image)
            node.settle(0.05)
        assert made.end() == 0, made.output
    assert f'{len(STAMPS)} messages in {bag}' in made.output
    assert [frame.stamp_ns for frame, _ in recorded_frames(bag)] == STAMPS

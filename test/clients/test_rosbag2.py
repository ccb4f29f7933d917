"""Bags that `ros2 bag` records are read here, and it plays into the nodes."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.resources import config_path
from blob_tracker.ros.bags import is_bag
from blob_tracker.ros.endpoints.recording import recorded_frames
from geometry_msgs.msg import Vector3Stamped
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.clients import needs
from support.processes import probe, Process, start

needs('ros2bag', 'rosbag2_storage_mcap', 'rosbag2_storage_sqlite3')

BAGS = Path(__file__).parents[1] / 'bags'
LOCATED = 28  # bearings that these bags give: see test/commands/test_replay.py
IMAGES, INFOS = '/camera/image_raw', '/camera/camera_info'
FRAMES = 30


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_what_is_recorded_is_read(storage: str, domain: int, tmp_path: Path) -> None:
    """Images of the simulator with their calibration."""
    bag = tmp_path / 'bag'
    command = ['ros2', 'bag', 'record', '-s', storage, '-o', str(bag), '--topics', IMAGES, INFOS]
    with probe(domain) as node:
        images, infos = node.record(Image, IMAGES), node.record(CameraInfo, INFOS)
        with start('simulator', domain), Process(command, domain) as recorder:
            node.spin_until(lambda: node.count_subscribers(IMAGES) == 2)
            node.spin_until(lambda: node.count_subscribers(INFOS) == 2)
            images.clear()
            node.spin_until(lambda: len(images) >= 2 * FRAMES)
            assert infos
            assert recorder.ctrl_c(20.0) == 0, recorder.output
    assert is_bag(bag)
    frames = list(recorded_frames(bag))
    assert len(frames) >= FRAMES


@pytest.mark.parametrize('bag', ['flash_mcap', 'flash_sqlite3'])
def test_what_is_played_is_located(bag: str, domain: int) -> None:
    """All bearings of the bag in simulated time, by the player of ROS 2."""
    common = ('--params-file', str(config_path('replay.yaml')))
    command = [
        'ros2', 'bag', 'play', str(BAGS / bag), '--clock', '--delay', '3',
        '--disable-keyboard-controls', '--topics', IMAGES, INFOS,
    ]
    with probe(domain) as node:
        bearings = node.record(Vector3Stamped, 'target/bearing')
        with (
            start('segmenter', domain, *common, use_sim_time=True) as segmenter,
            start('locator', domain, *common, use_sim_time=True),
        ):
            node.spin_until(lambda: node.count_publishers('target/bearing'))
            node.spin_until(lambda: node.count_subscribers('target/window/image_raw'))
            with Process(command, domain) as player:
                node.spin_until(lambda: not player.running, 60.0)
                assert player.wait() == 0, player.output
            node.spin_until(lambda: len(bearings) >= LOCATED)
            node.settle(0.3)  # any that should not be there
            assert len(bearings) == LOCATED
        assert 'play the bag with --clock' not in segmenter.output

"""Where a light is at a stamp of the camera, by the track of a tracker in another process."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.endpoints.latest_track import LatestTrack
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.messages.track import track_message
from blob_tracker.tracking import Track
from nav_msgs.msg import Odometry
import numpy as np
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

HERE_NS = 1_790_000_000_000_000_000
STATE = np.array([10.0, 5.0, 100.0, 0.0])  # mrad, mrad/s


@pytest.mark.parametrize('offset', [0.0, 37.0, -1.79e9])
def test_a_camera_of_another_clock_asks_by_its_own_stamps(offset: float, domain: int) -> None:
    """The tracker says what it took off; 20 ms later the light is 2 mrad further."""
    rclpy.init(domain_id=domain)
    try:
        node = Node('asking')
        latest = LatestTrack(node, 'target/track', Health(node, ''))
        tracks = node.create_publisher(Odometry, 'target/track', RESULT)
        track = Track(HERE_NS, STATE, np.eye(4))
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        stamp_ns = HERE_NS + round(1e9 * offset) + 20_000_000
        assert latest.seen_at(stamp_ns) is None
        message = track_message(track, 'optical', 'target', stamp_offset=offset)
        seen = None
        for _ in range(100):
            tracks.publish(message)
            executor.spin_once(timeout_sec=0.1)
            seen = latest.seen_at(stamp_ns)
            if seen is not None:
                break
        assert seen is not None
        assert seen.azimuth == pytest.approx(12.0, abs=1e-4)
        assert latest.seen_at(stamp_ns + 10**9) is None
        node.destroy_node()
    finally:
        rclpy.shutdown()

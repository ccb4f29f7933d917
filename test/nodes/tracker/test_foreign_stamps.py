"""Bearings with stamps of another clock: told, never called tracked, and taken off if asked to."""

from __future__ import annotations

import time

from blob_tracker.ros.endpoints.qos import RESULT, STATE
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
from std_msgs.msg import Bool
from support.processes import probe, start

TAI_NS = 37_000_000_000
FRAME_S = 0.02
COVARIANCE = 0.02**2 * np.eye(2)  # mrad^2


def test_a_clock_of_tai_is_named_and_can_be_taken_off(domain: int) -> None:
    """A camera that stamps by PTP: a WARN with the number, and predictions once it is set."""
    with probe(domain) as node, start('tracker', domain) as process:
        rays = node.create_publisher(PoseWithCovarianceStamped, 'target/ray', RESULT)
        predictions = node.record(Vector3Stamped, 'target/bearing_predicted')
        tracks = node.record(Odometry, 'target/track')
        tracked = node.record(Bool, 'target/tracked', STATE)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        node.spin_until(rays.get_subscription_count)

        def until(said: str) -> None:
            """Publish bearings of a light at rest until the tracker says this of them."""
            began = len(diagnostics)

            def seen() -> bool:
                bearing = Bearing(10.0, 5.0, COVARIANCE, time.time_ns() + TAI_NS)
                rays.publish(ray_message(bearing, 'optical'))
                node.spin(FRAME_S)
                return any(said in each.status[0].message for each in diagnostics[began:])

            node.spin_until(seen)

        until("s ahead of this computer's clock as they come (TAI, which PTP keeps)")
        assert any('set stamp_offset to 37.000' in each.status[0].message for each in diagnostics)
        assert not any('target tracked' in each.status[0].message for each in diagnostics)
        assert not predictions
        assert not any(each.data for each in tracked)

        assert node.set_parameter('tracker', 'stamp_offset', 37.0).successful
        until('target tracked')
        node.spin_until(lambda: predictions and tracked[-1].data)
        assert abs(predictions[-1].vector.x - 10.0) < 0.2  # 10 sigma
        stamp = predictions[-1].header.stamp
        assert abs(stamp.sec - time.time()) < 10.0

        node.spin_until(lambda: tracks and tracks[-1].twist.twist.linear.z == 37.0)
        assert node.set_parameter('tracker', 'stamp_offset', 0.0).successful
        assert node.set_parameter('tracker', 'stamp_offset_auto', True).successful
        until('target tracked')
        began = len(diagnostics)
        assert node.set_parameter('tracker', 'servo_delay', 0.01).successful
        until('target tracked')  # what was measured stays
        assert not any('jumped' in each.status[0].message for each in diagnostics[began:])
        assert not any('starting again' in each.status[0].message for each in diagnostics[began:])
        assert process.running
        assert process.end() == 0
    assert 'Traceback' not in process.output, process.output

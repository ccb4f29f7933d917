"""Bearings with stamps of another clock: told, never called tracked, and taken off if asked to."""

from __future__ import annotations

import time

from blob_tracker.ros.endpoints.qos import RESULT, STATE
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Bool
from support.processes import probe, start

TAI_NS, GPS_NS = 37_000_000_000, 18_000_000_000
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


def test_joints_and_a_gyro_of_another_clock_are_named(domain: int) -> None:
    """By how much, whose it may be, and what to do: not only that they do not fit the bearings."""
    with probe(domain) as node, start(
        'tracker', domain, joints__pan='pan', joints__tilt='tilt', imu__enabled=True
    ):
        rays = node.create_publisher(PoseWithCovarianceStamped, 'target/ray', RESULT)
        joints = node.create_publisher(JointState, 'joint_states', RESULT)
        imu = node.create_publisher(Imu, 'imu', RESULT)
        predictions = node.record(Vector3Stamped, 'target/bearing_predicted')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        node.spin_until(
            lambda: all(each.get_subscription_count() for each in (rays, joints, imu)))

        def until(said: str, joints_ns: int, imu_ns: int) -> None:
            """Publish all three until the tracker says this of the stamps ahead by so many ns."""
            began = len(diagnostics)

            def seen() -> bool:
                stand = JointState(name=['pan', 'tilt'], position=[0.1, 0.0])
                stand.header.stamp = from_ns(time.time_ns() + joints_ns)
                joints.publish(stand)
                turn = Imu()
                turn.header.frame_id = 'imu_link'
                turn.header.stamp = from_ns(time.time_ns() + imu_ns)
                imu.publish(turn)
                bearing = Bearing(10.0, 5.0, COVARIANCE, time.time_ns())
                rays.publish(ray_message(bearing, 'optical'))
                node.spin(FRAME_S)
                return any(said in each.status[0].message for each in diagnostics[began:])

            node.spin_until(seen)

        until('joint_states: stamps are 36.9', TAI_NS, 0)
        until("(TAI, which PTP keeps): have its driver stamp by the system's clock", TAI_NS, 0)
        assert not predictions
        until('imu: stamps are 17.9', 0, GPS_NS)
        until('as if there were no IMU: ', 0, GPS_NS)
        until('(GPS time): have its driver', 0, GPS_NS)
        assert predictions
        until('target tracked', 0, 0)


def test_stamps_of_0_are_no_clock(domain: int) -> None:
    """No offset would help, and none is advised."""
    with probe(domain) as node, start('tracker', domain, stamp_offset_auto=True):
        rays = node.create_publisher(PoseWithCovarianceStamped, 'target/ray', RESULT)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        node.spin_until(rays.get_subscription_count)

        def said() -> bool:
            rays.publish(ray_message(Bearing(10.0, 5.0, COVARIANCE, 0), 'optical'))
            node.spin(FRAME_S)
            return any(
                'all stamps are 0.000 s' in each.status[0].message for each in diagnostics)

        node.spin_until(said)
        assert not any('set stamp_offset' in each.status[0].message for each in diagnostics)

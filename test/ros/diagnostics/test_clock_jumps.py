"""What is of another time is forgotten when the ROS clock jumps back, and the jump is told."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.health import Health, WARN
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from rclpy.time import Time
from support.processes import Probe, probe

SECOND = 10**9
NAME = 'use_sim_time'


def set_clock(node: Probe, seconds: float) -> None:
    """Do what a message on /clock does."""
    node.get_clock().set_ros_time_override(
        Time(nanoseconds=round(seconds * SECOND), clock_type=node.get_clock().clock_type)
    )


def test_jumps(domain: int) -> None:
    """Back and to another clock, not forward; frames nearer to the new time are kept."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        node.set_parameters([Parameter(NAME, value=True)])
        set_clock(node, 100.0)
        forgotten: list[int] = []
        handle = on_clock_jump(node, Health(node, 'nothing'), forgotten.append)
        set_clock(node, 100.1)
        set_clock(node, 5000.0)
        assert forgotten == []
        set_clock(node, 4000.0)
        assert forgotten == [4500 * SECOND]
        node.spin_until(lambda: heard)
        status = heard[-1].status[0]
        assert status.level == WARN
        assert status.message == 'the ROS clock jumped back by 1000.000 s; starting again'
        # The stamp is of the ROS clock, the timer is not: that clock stands still.
        assert heard[-1].header.stamp.sec == 4000

        node.set_parameters([Parameter(NAME, value=False)])
        assert forgotten[1:] == [-1]
        node.set_parameters([Parameter(NAME, value=True)])
        assert forgotten[2:] == [-1]
        count = len(heard)
        node.spin_until(lambda: len(heard) > count)
        words = heard[count].status[0].message
        assert 'is now that of the system (use_sim_time)' in words
        assert 'is now that of /clock (use_sim_time)' in words
        assert handle is not None

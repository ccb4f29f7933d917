"""What a node does when its ROS clock jumps: a bag that begins again, another use_sim_time."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.ros.diagnostics.health import Health, WARN
from rclpy.clock import ClockChange, JumpHandle, JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node


def on_clock_jump(node: Node, health: Health, forget: Callable[[int], None]) -> JumpHandle:
    """
    Have a node forget what is of another time when its clock jumps back or is another one.

    A jump forward needs nothing: the frames that follow are too late for those before them.

    Parameters
    ----------
    node : Node
        The node; the ROS clock of use_sim_time jumps, or changes with that parameter.
    health : Health
        Hears of it.
    forget : callable
        Called with a time in ns: what has a later stamp is of before the jump. Frames that have
        jumped already, for they come on topics of their own, are not.

    Returns
    -------
    JumpHandle
        To be kept as long as the node lives.

    """

    def jumped(jump: TimeJump) -> None:
        now_ns = node.get_clock().now().nanoseconds
        if jump.clock_change == ClockChange.ROS_TIME_NO_CHANGE:
            back_ns = -jump.delta.nanoseconds
            health.fault(
                WARN, f'the ROS clock jumped back by {back_ns / 1e9:.3f} s; starting again'
            )
            forget(now_ns + back_ns // 2)
        else:
            simulated = jump.clock_change == ClockChange.ROS_TIME_ACTIVATED
            health.fault(
                WARN,
                f'the ROS clock is now that of {"/clock" if simulated else "the system"} '
                '(use_sim_time); starting again',
            )
            forget(-1)

    # Simulators and players repeat a tick, but never go back by less than they advance.
    threshold = JumpThreshold(
        min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=True
    )
    return node.get_clock().create_jump_callback(threshold, post_callback=jumped)

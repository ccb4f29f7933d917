"""
A process that subscribes as any rclpy node does, and tells when each message arrived.

`python -m benchmarks.latency.subscriber image hop/image_raw`, or `bearing target/bearing`; it says
`[]` when it listens, stamp and monotonic time, ns, of the first message as soon as it is there,
and, when its standard input ends, those of all.
"""

from __future__ import annotations

import sys
from threading import Thread
import time
from typing import Any

from benchmarks.latency.source import report, wait_for_the_end
from blob_tracker.ros.qos import IMAGE_IN, RESULT
from blob_tracker.ros.stamp import to_ns
from geometry_msgs.msg import Vector3Stamped
import rclpy
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import Image

KINDS = {'image': (Image, IMAGE_IN), 'bearing': (Vector3Stamped, RESULT)}


def main(kind: str, topic: str) -> None:
    """Receive until the end."""
    arrived = []

    def take(message: Any) -> None:
        now_ns = time.monotonic_ns()
        arrived.append((to_ns(message.header.stamp), now_ns))
        if len(arrived) == 1:
            report(arrived)

    def end() -> None:
        wait_for_the_end()
        rclpy.try_shutdown()

    rclpy.init()
    node = rclpy.create_node('subscriber')
    message, qos = KINDS[kind]
    node.create_subscription(message, topic, take, qos)
    Thread(target=end, daemon=True).start()
    report([])
    try:
        rclpy.spin(node)
    except ExternalShutdownException:
        pass
    report(arrived)


if __name__ == '__main__':
    main(*sys.argv[1:])

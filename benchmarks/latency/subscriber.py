"""
A process that subscribes as any rclpy node does, and tells when each message arrived.

`python -m benchmarks.latency.subscriber image hop/image_raw`, or `bearing target/bearing`; it says
`[]` when it listens. To each line on its standard input it answers with stamp and monotonic time,
ns: to `"first"` those of the first message that there ever was, as soon as it is there, to `"new"`
those of all since the last such line.
"""

from __future__ import annotations

import sys
from threading import Event, Thread
import time
from typing import Any

from benchmarks.latency.source import report, requests
from blob_tracker.ros.endpoints.qos import IMAGE_IN, RESULT
from blob_tracker.ros.messages.stamp import to_ns
from geometry_msgs.msg import Vector3Stamped
import rclpy
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import Image

KINDS = {'image': (Image, IMAGE_IN), 'bearing': (Vector3Stamped, RESULT)}


def main(kind: str, topic: str) -> None:
    """Receive until the end."""
    arrived: list[tuple[int, int]] = []
    begun = Event()

    def take(message: Any) -> None:
        arrived.append((to_ns(message.header.stamp), time.monotonic_ns()))
        begun.set()

    def answer() -> None:
        for asked in requests():
            if asked == 'first':
                begun.wait()
                report(arrived[0])
            else:
                count = len(arrived)
                report(arrived[:count])
                del arrived[:count]
        rclpy.try_shutdown()

    rclpy.init()
    node = rclpy.create_node('subscriber')
    message, qos = KINDS[kind]
    node.create_subscription(message, topic, take, qos)
    Thread(target=answer, daemon=True).start()
    report([])
    try:
        rclpy.spin(node)
    except ExternalShutdownException:
        pass


if __name__ == '__main__':
    main(*sys.argv[1:])

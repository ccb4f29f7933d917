"""
A process that publishes bearings as the locator does, without the work.

`python -m benchmarks.latency.bearings hop/bearing`; it says `[]` when somebody has subscribed.
Each line on its standard input, `{"rate": ..., "seconds": ...}`, streams once, as camera.py does.
"""

from __future__ import annotations

import sys
import time

from benchmarks.latency.source import FRAME_ID, report, requests, send
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.types import Pixels
from geometry_msgs.msg import Vector3Stamped
import numpy as np
import rclpy

NO_FRAME = np.zeros((1, 1), dtype=np.uint8)
LAST = 0.3  # s that the last bearing has for its way


def main(topic: str) -> None:
    """Publish."""
    rclpy.init()
    node = rclpy.create_node('bearings')
    publisher = node.create_publisher(Vector3Stamped, topic, RESULT)
    message = Vector3Stamped()
    message.header.frame_id = FRAME_ID

    def publish(_: Pixels, stamp_ns: int) -> int:
        message.header.stamp = from_ns(stamp_ns)
        now_ns = time.monotonic_ns()
        publisher.publish(message)
        return now_ns

    while not publisher.get_subscription_count():
        time.sleep(0.01)
    report([])
    for asked in requests():
        sent = send([NO_FRAME], asked['rate'], asked['seconds'], publish)
        time.sleep(LAST)
        report(sent)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main(*sys.argv[1:])

"""
A process that publishes drawn frames as a driver does, and tells when each one left.

`python -m benchmarks.latency.camera '{"topic": ..., "info": true, "subscribers": 1}'`; it says
`[]` when so many have subscribed. Each line on its standard input, as `{"width": ...,
"height": ..., "rate": ..., "seconds": ...}`, streams once: it prints stamp, monotonic time and
whether lit of each frame, ns.
"""

from __future__ import annotations

import json
import sys
import time

from benchmarks.latency.source import camera_model, draw, FRAME_ID, report, requests, send
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.types import Pixels
import rclpy
from sensor_msgs.msg import CameraInfo, Image

LAST = 0.3  # s that the last frame has for its way


def main(topic: str, info: bool, subscribers: int) -> None:
    """Publish; `info` adds the camera_info that a tracker needs, which a bare hop has not."""
    rclpy.init()
    node = rclpy.create_node('camera')
    images = node.create_publisher(Image, f'{topic}/image_raw', IMAGE_OUT)
    infos = node.create_publisher(CameraInfo, f'{topic}/camera_info', IMAGE_OUT)
    image = Image()

    def stream(width: int, height: int, rate: float, seconds: float) -> None:
        frames = draw(width, height, rate)
        camera_info = from_camera_model(camera_model(width, height), width, height)

        def publish(pixels: Pixels, stamp_ns: int) -> int:
            from_pixels(pixels, stamp_ns, FRAME_ID, image)
            stamped(camera_info, stamp_ns, FRAME_ID)
            now_ns = time.monotonic_ns()
            if info:  # first, as our own camera's
                infos.publish(camera_info)
            images.publish(image)
            return now_ns

        sent = send(frames, rate, seconds, publish)
        time.sleep(LAST)
        report(sent)

    while images.get_subscription_count() < subscribers:
        time.sleep(0.01)
    report([])
    for asked in requests():
        stream(**asked)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main(**json.loads(sys.argv[1]))

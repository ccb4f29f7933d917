"""~/debug_image: what a segmenter saw, drawn while somebody looks."""

from __future__ import annotations

from blob_tracker.ros.image import from_picture
from blob_tracker.ros.qos import IMAGE_OUT, publisher
from blob_tracker.segmentation.look import Look
from blob_tracker.segmentation.picture import draw
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import Image

# s from one picture to the next. Frames with a window have the first call, those with a candidate
# the second: at a fixed pace every picture could be of an unlit frame.
WITH_WINDOW, WITH_CANDIDATE, WITH_NOTHING = 0.1, 0.2, 0.3


class DebugImage:
    """
    Publish pictures of what a segmenter saw, ten a second at most.

    Parameters
    ----------
    node : Node
        Publishes them.

    """

    def __init__(self, node: Node) -> None:
        self._publisher = publisher(node, Image, '~/debug_image', IMAGE_OUT)
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._drawn_ns = 0

    def offer(self, look: Look, stamp_ns: int, frame_id: str) -> None:
        """Publish a frame's picture if somebody subscribes and it is time for one."""
        if not self._publisher.get_subscription_count():
            return
        pause = WITH_NOTHING
        if look.windows:
            pause = WITH_WINDOW
        elif look.candidates:
            pause = WITH_CANDIDATE
        now_ns = self._clock.now().nanoseconds
        if now_ns - self._drawn_ns >= 1e9 * pause:
            self._drawn_ns = now_ns
            self._publisher.publish(from_picture(draw(look), stamp_ns, frame_id))

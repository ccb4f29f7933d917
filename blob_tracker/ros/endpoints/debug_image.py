"""~/debug_image: what a node saw, drawn while somebody looks."""

from __future__ import annotations

from collections.abc import Callable
import time

from blob_tracker.ros.endpoints.qos import IMAGE_OUT, publisher
from blob_tracker.ros.messages.image import from_picture
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import Image

PAUSE_S = 0.1  # s from one picture to the next
ASK_S = 0.02  # s from one question whether somebody subscribes to the next


class DebugImage:
    """
    Publish pictures of what a node saw, ten a second at most.

    Parameters
    ----------
    node : Node
        Publishes them.

    """

    def __init__(self, node: Node) -> None:
        self._publisher = publisher(node, Image, '~/debug_image', IMAGE_OUT)
        self._drawn_ns = 0
        self._asked_ns = 0  # when it was last asked whether somebody subscribes

    def offer(
        self,
        draw: Callable[[], NDArray[np.uint8]],
        stamp_ns: int,
        frame_id: str,
        pause: float = PAUSE_S,
    ) -> None:
        """
        Publish a picture if somebody subscribes and it is time for one.

        Parameters
        ----------
        draw : callable
            Returns the (h, w, 3) picture, blue, green and red; not called where none is due.
        stamp_ns : int
            Of what it shows, ns.
        frame_id : str
            Name of the optical frame.
        pause : float
            s since the last picture before which this one is not due: longer for what is of less
            interest.

        """
        now_ns = time.monotonic_ns()
        if now_ns - self._drawn_ns < 1e9 * pause or now_ns - self._asked_ns < 1e9 * ASK_S:
            return
        self._asked_ns = now_ns
        if self._publisher.is_wanted:
            self._drawn_ns = now_ns
            self._publisher.publish(from_picture(draw(), stamp_ns, frame_id))

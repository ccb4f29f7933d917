"""
A process with the pipeline's nodes, fed in memory as its camera node feeds them.

`python -m benchmarks.latency.pipeline`; each line on its standard input, as `{"width": ...,
"height": ..., "rate": ..., "seconds": ...}`, streams once: it prints stamp, monotonic time and
whether lit of each frame, ns, and at the end its garbage collections as node.py does.
"""

from __future__ import annotations

from collections.abc import Iterator
import sys
from threading import Thread
import time

from benchmarks.latency import pauses
from benchmarks.latency.source import camera_model, draw, FRAME_ID, report, requests, send
from blob_tracker.nodes.locator import LocatorNode
from blob_tracker.nodes.pipeline import compile_all
from blob_tracker.nodes.rehearsal import Rehearsal
from blob_tracker.nodes.segmenter import SegmenterNode
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.endpoints.delivery import Deliver
from blob_tracker.ros.endpoints.frame_topics import FrameTopics
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.process import run
from blob_tracker.types import Frame, Pixels
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo

FULL_SCALE = 255  # DN


class Source(Node):
    """
    Frames from a thread of their own, as those of the camera node.

    Parameters
    ----------
    deliver : callable
        Takes them in memory.
    rehearsal : Rehearsal
        Run before a frame, as the camera node does.

    """

    def __init__(
        self, deliver: Deliver[tuple[Frame, CameraInfo]], rehearsal: Rehearsal
    ) -> None:
        super().__init__('source')
        self._rehearsal = rehearsal
        self._frames = FrameTopics(self, Health(self, 'no frame was sent'), deliver)
        Thread(target=self._stream, daemon=True).start()

    def _stream(self) -> None:
        """Stream as often as asked to, then end the process."""
        for asked in requests():
            self._stream_once(**asked)
        report(pauses.watch())
        rclpy.try_shutdown()

    def _stream_once(self, width: int, height: int, rate: float, seconds: float) -> None:
        frames = draw(width, height, rate)
        info = from_camera_model(camera_model(width, height), width, height)

        def publish(pixels: Pixels, stamp_ns: int) -> int:
            now_ns = time.monotonic_ns()
            self._frames.publish(Frame(pixels, stamp_ns, FULL_SCALE), info, FRAME_ID)
            return now_ns

        report(send(frames, rate, seconds, publish, self._wait))

    def _wait(self, pause: float) -> None:
        """Wait for the next frame, and rehearse meanwhile."""
        due = time.monotonic() + pause
        first = self._rehearsal.pause()
        if first < pause:
            time.sleep(first)
            self._rehearsal.run()
        time.sleep(max(due - time.monotonic(), 0.0))


def linked_nodes() -> Iterator[Node]:
    """Yield the nodes of blob_tracker.nodes.pipeline with this source."""
    locating = LocatorNode(listen=False)
    yield locating
    segmenting = SegmenterNode(
        listen=False, deliver=locating.locate, announce=locating.set_lights
    )
    yield segmenting
    yield Source(segmenting.segment, segmenting.rehearsal)


if __name__ == '__main__':
    pauses.watch()
    sys.exit(run(linked_nodes, compile_all))

"""Search and fit of a light that is nobody's: the next frame finds them in the caches."""

from __future__ import annotations

from collections import deque
from math import inf
import time

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.pipeline import Pipeline
from blob_tracker.ros.messages.target import bearing_bytes
from blob_tracker.types import Frame, Pixels, SensorNoise
import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

SHORTEST_NS = 5_000_000  # ns from frame to frame, below which the caches are as the last one left
LONGEST_NS = 200_000_000  # ns, beyond which it is not known well enough when the next one comes
LEAD_NS = 1_500_000  # ns before a frame that it takes, with the jitter of a camera
LAST = 8  # intervals, of which the least counts: better too early than in the way of a frame
WIDTH, HEIGHT = 128, 96  # px: of a smaller frame the region about a light that is followed is most
SIGMA_PX, PEAK_DN, LEVEL_DN, FULL_SCALE_DN = 1.6, 120.0, 20.0, 255
NOISE = SensorNoise(gain=40.0, read_noise=1.2)
IMAGES = 4
PERIOD_NS = 16_666_667  # ns of its own stamps


class Rehearsal:
    """
    Do what a lit frame needs once before it comes, with a light that is nobody's.

    Between two frames of a camera at 60 Hz other programs have the processor, and what a frame
    runs through is no longer in its caches: the way to a bearing takes twice as long as in frames
    that follow at once. Whoever waits for the frames rehearses in the same thread, which is on the
    same core. All that it changes is its own.

    Parameters
    ----------
    fits : bool
        Whether the light is also placed, where that is done in the same process.

    """

    def __init__(self, *, fits: bool) -> None:
        self._fits = fits
        self._kinds: dict[str, tuple[Pipeline, list[Pixels]]] = {}  # by the type of the pixels
        self._kind = ''
        self._came_ns = 0
        self._intervals: deque[int] = deque(maxlen=LAST)
        self._at_ns: int | None = None
        self._count = 0

    def expect(self, came_ns: int, kind: str, wanted: bool) -> None:
        """
        Take note of a frame.

        Parameters
        ----------
        came_ns : int
            When it came, monotonic, ns.
        kind : str
            Type of its pixels.
        wanted : bool
            Whether the next one is likely to show the light.

        """
        self._intervals.append(came_ns - self._came_ns)
        self._came_ns, self._kind = came_ns, kind
        least = min(self._intervals)
        regular = wanted and SHORTEST_NS <= least <= LONGEST_NS
        self._at_ns = came_ns + least - LEAD_NS if regular else None

    def pause(self) -> float:
        """Return in how many s it is to be run; infinity where it is not."""
        if self._at_ns is None:
            return inf
        return max((self._at_ns - time.monotonic_ns()) / 1e9, 0.0)

    def run(self) -> None:
        """Track the light for a dark and a lit frame."""
        self._at_ns = None
        if self._kind not in self._kinds:
            self._kinds[self._kind] = _new(self._kind)
        pipeline, images = self._kinds[self._kind]
        for _ in range(2):
            self._count += 1
            image = images[self._count % len(images)]
            frame = Frame(image, self._count * PERIOD_NS, FULL_SCALE_DN)
            if not self._fits:
                pipeline.segmenter.sightings(frame)
                continue
            for placed in pipeline.placed(frame):
                bearing_bytes(placed.bearing, '')


class TimedRehearsal(Rehearsal):
    """
    Rehearse in a node whose frames or windows come through its executor, by a timer of that.

    Parameters
    ----------
    node : Node
        Has them.
    fits : bool
        As of `Rehearsal`.

    """

    def __init__(self, node: Node, *, fits: bool) -> None:
        super().__init__(fits=fits)
        self._timer = node.create_timer(
            LONGEST_NS / 1e9, self.run, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._timer.cancel()

    def expect(self, came_ns: int, kind: str, wanted: bool) -> None:
        """Take note of a frame, and set the timer."""
        super().expect(came_ns, kind, wanted)
        pause = self.pause()
        if pause < inf:
            self._timer.timer_period_ns = int(1e9 * pause)
            self._timer.reset()

    def run(self) -> None:
        """Rehearse once."""
        self._timer.cancel()
        super().run()


def _new(kind: str) -> tuple[Pipeline, list[Pixels]]:
    """Return what tracks the light in pixels of that type, and the frames of it: lit, dark, ..."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    r2 = (columns - 0.5 * WIDTH - 0.2)**2 + (rows - 0.5 * HEIGHT + 0.3)**2
    pulse = PEAK_DN * np.exp(-0.5 * r2 / SIGMA_PX**2)
    images = []
    for index in range(IMAGES):
        mean = LEVEL_DN + ((index + 1) % 2) * pulse
        noise = (7 * rows + 13 * columns + 5 * index) % 4 - 1.5  # numpy.random takes 10 ms to load
        images.append(np.rint(mean + noise).clip(0, FULL_SCALE_DN).astype(kind))
    matrix = pinhole_matrix(600.0, WIDTH, HEIGHT)
    camera_model = CameraModel(WIDTH, HEIGHT, matrix)
    return Pipeline(camera_model, noise=NOISE), images

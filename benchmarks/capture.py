"""
From the driver's buffer to the reader: decoding, stamp and the way through the capture thread.

The camera is `V4l2Camera` but for the kernel: a byte in a pipe is a filled buffer, so that the
thread is woken and the reader waits as with a device. What the kernel itself takes is not in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import errno
import mmap
import os
from statistics import median
import time
from typing import Any

from blob_tracker.capture import Grabber, V4l2Camera, videodev2
from blob_tracker.capture.clock import RealtimeClock
from blob_tracker.capture.control_events import ControlEvents
from blob_tracker.capture.device_controls import DeviceControls
from blob_tracker.capture.field_dealer import FieldDealer
from blob_tracker.capture.format import StreamFormat
from blob_tracker.capture.frame_count import FrameCount
from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.ring import Ring
from blob_tracker.capture.selection import SensorRegion
from blob_tracker.capture.stamps import Exposure, ExposureControls, MidExposure
import numpy as np

Tick = Callable[[str], None]

SIZES = ((640, 480), (1920, 1200))
RING = 32  # buffers: 10 MB of the smallest, more than stays in a core's own cache
FRAMES = 200  # of a repeat
INTERVAL = 0.004  # s between frames: the reader waits for each


@dataclass(frozen=True)
class Row:
    """
    One size of GREY frames.

    Parameters
    ----------
    size : str
        'width x height'.
    seconds : float
        From the return of DQBUF in the capture thread to that of `Grabber.newest` in the
        reader's: median over the frames of a repeat, median of all repeats.
    reference : float
        Seconds of one copy of the same buffers, likewise.
    ratio : float
        Median over the repeats of the one over the other.

    """

    size: str
    seconds: float
    reference: float
    ratio: float


class PipeCamera(V4l2Camera):
    """A camera whose driver is a pipe and a ring of memory."""

    def __init__(self, width: int, height: int) -> None:
        self.device = 'pipe'
        self.saturation = 255
        self.dequeued_ns = 0
        self.width, self.height = width, height
        self._fd, self._filled = os.pipe()
        os.set_blocking(self._fd, False)
        self.frame_rate = 1.0 / INTERVAL
        self._controls = DeviceControls(self.device, self._call)
        self._count = FrameCount(numbered=True)
        self._clock = RealtimeClock()
        self._format = StreamFormat(
            videodev2.BUF_TYPE_VIDEO_CAPTURE, 'GREY', width, height, width, 255,
            PIXEL_FORMATS['GREY'].luma)
        self._region = SensorRegion(0, 0, (1, 1), (width, height))
        self._binning, self._given_line_time = (1, 1), 0.0
        self._events = ControlEvents(self._call, ())
        self._exposure = ExposureControls(self._call, {}, width, height, Exposure(1_000_000))
        self._middle = MidExposure('exposure start', self._exposure.read())
        self._dealer = FieldDealer(self.fields, stamps_end=False)
        self._ring = Ring(self._call, self._fd, self.device, lambda: '')
        self._ring.memory += [mmap.mmap(-1, width * height) for _ in range(RING)]
        random = np.random.default_rng(1)
        for memory in self._ring.memory:
            memory[:] = random.integers(0, 256, width * height, dtype=np.uint8).tobytes()
        self._count_filled = 0

    def fill(self) -> None:
        """Let the driver have a frame."""
        os.write(self._filled, b'x')

    def close(self) -> None:
        """Give the pipe and the memory back."""
        os.close(self._filled)
        super().close()

    def copy_seconds(self) -> float:
        """Return the seconds of one copy of a buffer."""
        took = []
        for memory in self._ring.memory:
            began = time.perf_counter()
            np.frombuffer(memory, np.uint8).copy()
            took.append(time.perf_counter() - began)
        return median(took)

    def _call(self, number: int, argument: Any) -> None:
        if number == videodev2.DQBUF:
            os.read(self._fd, 1)
            now_ns = self.dequeued_ns = time.monotonic_ns()
            argument.index = self._count_filled % RING
            argument.bytesused = self.width * self.height
            argument.sequence = self._count_filled
            argument.timestamp.tv_sec, rest = divmod(now_ns, 1_000_000_000)
            argument.timestamp.tv_usec = rest // 1000
            self._count_filled += 1
        elif number != videodev2.QBUF:
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(SIZES)


def run(repeats: int, tick: Tick) -> list[Row]:
    """Return the row of each size."""
    rows = []
    for width, height in SIZES:
        tick(f'capture {width} x {height}')
        rows.append(measure(width, height, repeats, FRAMES))
    return rows


def measure(width: int, height: int, repeats: int, frames: int) -> Row:
    """Return the row of one size; copies and frames take turns by the repeat."""
    ours, copies = [], []
    camera = PipeCamera(width, height)
    with camera, Grabber(camera) as grabber:
        for _ in range(repeats):
            took = []
            for _ in range(frames):
                time.sleep(INTERVAL)
                camera.fill()
                grabber.newest(10.0)
                took.append((time.monotonic_ns() - camera.dequeued_ns) / 1e9)
            ours.append(median(took))
            copies.append(camera.copy_seconds())
        assert grabber.drops == grabber.overruns == 0
    return Row(f'{width} x {height}', median(ours), median(copies),
               median(our / copy for our, copy in zip(ours, copies)))

"""The way of a frame to its reader is measured on frames that arrive."""

from __future__ import annotations

from benchmarks import capture
from benchmarks.capture import Row
from benchmarks.report import Report
from benchmarks.targets import judge
from blob_tracker.capture import Grabber
import numpy as np


def test_frames_are_those_of_the_ring_in_order() -> None:
    """All run through V4l2Camera's own decoding, with growing stamps."""
    camera = capture.PipeCamera(40, 30)
    with camera, Grabber(camera) as grabber:
        stamps = []
        for index in range(2 * capture.RING):
            camera.fill()
            frame = grabber.newest(10.0)
            assert frame.image.shape == (30, 40)
            memory = camera._ring.memory[index % capture.RING]
            np.testing.assert_array_equal(frame.image.ravel(), np.frombuffer(memory, np.uint8))
            stamps.append(frame.stamp_ns)
    assert np.all(np.diff(stamps) > 0)


def test_times_are_positive_and_hold_together() -> None:
    """A ratio of medians is near the median of ratios."""
    row = capture.measure(64, 48, 3, 5)
    assert row.seconds > 0.0 and row.reference > 0.0 and row.ratio > 0.0


def test_the_target_is_that_of_the_named_size() -> None:
    """The larger frame is in the table alone."""
    rows = [Row('640 x 480', 310e-6, 30e-6, 10.0), Row('1920 x 1200', 2e-3, 1e-3, 2.0)]
    (missed,) = judge(Report(capture=rows), [])
    assert not missed.met and missed.measured == 310.0

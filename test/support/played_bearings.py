"""Bearings, time and a platform, played to a tracker that is a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import pi, sin
import time

from blob_tracker.ros.endpoints.qos import RESULT, STATE
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.ros.messages.track import to_track
from blob_tracker.tracking import Tracker
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Bool
from support.processes import Probe, probe, Process, start
from support.slowness import slowness

MS = 1_000_000  # ns
FRAME = 33 * MS  # between two bearings
LATENCY = 20 * MS  # from the stamp of a bearing to its arrival
SIGMA = 0.02  # mrad, of the bearings
FIRST = 0.3  # s for what comes of a bearing: nothing, of the first two of a track
COAST, MAX_SIGMA = 500 * MS, 20.0  # mrad; the defaults
# mrad: doubles that go through a quaternion, once each way; angles are up to 1000 mrad.
ROUNDING = 1e-9


def path(stamp_ns: int) -> tuple[float, float]:
    """Return where the target is: a swing of 60 mrad in 4 s, mrad."""
    phase = 2.0 * pi * (stamp_ns % (4000 * MS)) / (4000 * MS)
    return 60.0 * sin(phase), 20.0 * sin(phase + 1.0)


class Played:
    """Bearings, time and a platform that the test plays to a tracker."""

    def __init__(self, node: Probe, process: Process, topic: str) -> None:
        self.node, self.process = node, process
        self.topic = topic
        self.now_ns = 1_700_000_000_000 * MS
        self._clock = node.create_publisher(Clock, '/clock', RESULT)
        self.rays = node.create_publisher(PoseWithCovarianceStamped, f'{topic}/ray', RESULT)
        self.imu = node.create_publisher(Imu, 'imu', RESULT)
        self.joints = node.create_publisher(JointState, 'joint_states', RESULT)
        self.predictions = node.record(Vector3Stamped, f'{topic}/bearing_predicted', 1000)
        self.tracks = node.record(Odometry, f'{topic}/track', 1000)
        self.tracked = node.record(Bool, f'{topic}/tracked', STATE)
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        ours = (self._clock, self.rays)
        node.spin_until(lambda: all(each.get_subscription_count() for each in ours))
        node.spin_until(lambda: node.count_publishers(f'{topic}/bearing_predicted'))
        node.meet('tracker')
        self.tick(0)

    def tick(self, nanoseconds: int, step: int = 5 * MS) -> None:
        """Let time pass in small steps."""
        end_ns = self.now_ns + nanoseconds
        while True:
            self.now_ns = min(self.now_ns + step, end_ns)
            self._clock.publish(Clock(clock=from_ns(self.now_ns)))
            if self.now_ns >= end_ns:
                self.node.settle(0.004)
                return
            self.node.spin(0.004)

    def message(
        self, azimuth: float, elevation: float, sigma: float = SIGMA, age: int = LATENCY
    ) -> PoseWithCovarianceStamped:
        """Return the message of a bearing, mrad, of a moment ago."""
        covariance = sigma**2 * np.array([[1.0, 0.2], [0.2, 1.5]])
        bearing = Bearing(azimuth, elevation, covariance, self.now_ns - age)
        return ray_message(bearing, 'optical')

    def take(self, message: PoseWithCovarianceStamped) -> None:
        """Publish a good bearing, and wait for what comes of it, if anything does."""
        before = [len(self.tracks), len(self.predictions)]
        self.rays.publish(message)
        for messages, count in zip((self.tracks, self.predictions), before):
            until = time.monotonic() + FIRST * slowness()
            while len(messages) == count and time.monotonic() < until:
                self.node.spin(0.005)
            if len(messages) == count:
                return  # nothing comes of it; and no prediction without a track

    def compare(
        self, message: PoseWithCovarianceStamped, tracker: Tracker, ahead: int = 0
    ) -> None:
        """Have both filter a bearing, and expect the same track and prediction so far ahead."""
        self.predictions.clear()
        count = len(self.tracks)
        self.take(message)
        tracker.update(to_bearing(message))
        seen = tracker.seen_at(to_ns(message.header.stamp))
        if seen is None:
            assert len(self.tracks) == count
            assert not self.predictions
            return
        self.node.spin_until(lambda: len(self.tracks) > count)
        track = to_track(self.tracks[-1])
        assert track.stamp_ns == seen.stamp_ns
        np.testing.assert_allclose(track.state, seen.state, rtol=1e-9, atol=ROUNDING)
        np.testing.assert_allclose(track.angle_covariance, seen.angle_covariance, rtol=1e-9)
        np.testing.assert_allclose(track.rate_covariance, seen.rate_covariance, rtol=1e-9)
        if tracker.at(self.now_ns + ahead) is None:  # it is not sure enough so far ahead
            assert not self.predictions
            return
        self.node.spin_until(lambda: self.predictions)
        assert len(self.predictions) == 1
        prediction = self.predictions[0]
        assert to_ns(prediction.header.stamp) == self.now_ns + ahead
        expected = tracker.at(self.now_ns + ahead)
        assert prediction.vector.x == pytest.approx(expected.azimuth, abs=ROUNDING)
        assert prediction.vector.y == pytest.approx(expected.elevation, abs=ROUNDING)
        assert prediction.vector.z == 0.0

    def follow(self, frames: int) -> None:
        """Publish good bearings of the target on its path."""
        for _ in range(frames):
            self.tick(FRAME)
            self.take(self.message(*path(self.now_ns - LATENCY)))

    def said(self, sentence: str) -> bool:
        """Tell whether a diagnostic has said this."""
        return any(sentence in each.status[0].message for each in self._of_tracker())

    def level(self, sentence: str) -> int:
        """Return the level at which a sentence was said."""
        return max(
            each.status[0].level[0] for each in self._of_tracker()
            if sentence in each.status[0].message
        )

    def shown(self, key: str) -> str:
        """Return a value of the last diagnostic; empty before it says it."""
        for array in self._of_tracker()[-1:]:
            return {each.key: each.value for each in array.status[0].values}.get(key, '')
        return ''

    def expect_shown(self, key: str, value: str) -> None:
        """Wait for a diagnostic with a value that begins like this."""
        self.node.spin_until(lambda: self.shown(key).startswith(value))

    def expect_tracked(self, *, tracked: bool) -> None:
        """Wait until the target is said to be tracked, or not to be."""
        self.node.spin_until(lambda: self.tracked and self.tracked[-1].data is tracked)

    def expect(self, sentence: str) -> None:
        """Wait for a diagnostic that says this."""
        self.node.spin_until(lambda: self.said(sentence))
        assert self.process.running

    def _of_tracker(self) -> list[DiagnosticArray]:
        return [each for each in self.diagnostics if each.status[0].name == '/tracker: tracking']


@contextmanager
def playing(domain: int, topic: str = 'target', **parameters: object) -> Iterator[Played]:
    """Start a tracker in simulated time; it must end well, whatever it was fed."""
    with (
        probe(domain) as node,
        start('tracker', domain, use_sim_time=True, **parameters) as process,
    ):
        yield Played(node, process, topic)
        assert process.running
        assert process.end() == 0
    assert 'Traceback' not in process.output, process.output

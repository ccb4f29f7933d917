"""A bearing waits until it is known how the camera stood, and no longer than it may."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from blob_tracker.nodes.tracker import platform
from blob_tracker.nodes.tracker.light_track import LightTrack, MOST_HELD
from blob_tracker.nodes.tracker.platform import Platform
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.tracking import PanTiltAngles, Tracker
from blob_tracker.types import Bearing
import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

MS = 1_000_000  # ns
NO_JOINTS = {
    'imu.enabled': False, 'imu.frame_id': 'imu_link', 'imu.roll': 0.0, 'imu.pitch': 0.0,
    'imu.yaw': 0.0, 'imu.stamp_offset': 0.0, 'imu.bias_x': 0.0, 'imu.bias_y': 0.0,
    'imu.bias_z': 0.0, 'joints.pan': '', 'joints.tilt': '', 'joints.pan_reversed': False,
    'joints.tilt_reversed': False, 'joints.sigma': 0.03, 'joints.frame_id': 'base',
    'imu.use_tf': False, 'joints.use_tf': False, 'tf_patience': 0.1,
}
JOINTS = {**NO_JOINTS, 'joints.pan': 'pan', 'joints.tilt': 'tilt'}
FOREVER = 10**18  # ns


class Heard(Health):
    """Health that remembers the stamp of each bearing that became part of the track, ns."""

    def __init__(self, node: Node) -> None:
        super().__init__(node, '')
        self.tracked_ns: list[int] = []

    def left(self, stamp_ns: int) -> None:
        """Remember it."""
        super().left(stamp_ns)
        self.tracked_ns.append(stamp_ns)


class Light:
    """A light that is seen from a pan/tilt which swings."""

    def __init__(self, node: Node) -> None:
        self.platform = Platform(node, Health(node, ''), Lock(), lambda: None)
        self.platform.change(JOINTS)()
        self.health = Heard(node)
        self.track = LightTrack(node, self.health, '', self.platform)
        self.start_ns = node.get_clock().now().nanoseconds
        self.track.use(self.tracker())

    def tracker(self) -> Tracker:
        """Return another tracker of what the platform knows."""
        return Tracker(pan_tilt=self.platform.angles)

    def stamp(self, milliseconds: int) -> int:
        """Return a stamp, ns, so long after the start."""
        return self.start_ns + milliseconds * MS

    def joints(self, milliseconds: int) -> None:
        """Have the joints' angles come."""
        pan = place(milliseconds)
        self.platform.angles.push(self.stamp(milliseconds), pan, 0.0)

    def bearing(self, milliseconds: int) -> Bearing:
        """Return the bearing of a light straight ahead of the base."""
        return Bearing(
            -1e3 * place(milliseconds), 0.0, 4e-4 * np.eye(2), self.stamp(milliseconds)
        )

    def take(self, bearing: Bearing) -> None:
        """Have a bearing come."""
        self.track.take(Delivery(bearing, 'optical'), 0)

    def hold(self, milliseconds: int) -> None:
        """Have the bearing of a time come, which waits if it has to."""
        self.take(self.bearing(milliseconds))

    def released(self) -> list[int]:
        """Return the time of each bearing that has become part of the track since, ms."""
        self.track.release(0)
        stamps, self.health.tracked_ns = self.health.tracked_ns, []
        return [(each - self.start_ns) // MS for each in stamps]


def place(milliseconds: int) -> float:
    """Return where the pan stands, rad: it accelerates by 4 rad/s^2."""
    return 2.0 * (1e-3 * milliseconds) ** 2


@contextmanager
def light(domain: int) -> Iterator[Light]:
    """Make one, and a node for it."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    node = Node('own', context=context)
    try:
        yield Light(node)
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let bearings wait for as long as the test runs."""
    monkeypatch.setattr(platform, 'PATIENCE', FOREVER)


def test_a_bearing_waits_for_the_joints(patient: None, domain: int) -> None:
    """In order, and the track is the very one of angles that were there before."""
    angles = PanTiltAngles(sigma=3e-5)
    tracker = Tracker(pan_tilt=angles)
    with light(domain) as seen:
        for time in range(0, 300, 5):
            angles.push(seen.stamp(time), place(time), 0.0)
        for time in range(0, 200, 5):
            seen.joints(time)
            if time % 20 == 0:
                seen.hold(time + 8)
                seen.hold(time + 9)
            assert seen.released() == ([time - 2, time - 1] if time % 20 == 10 else [])
            if time % 20 == 10:
                for each in (time - 2, time - 1):
                    tracker.update(seen.bearing(each))
                track, expected = (
                    each.seen_at(seen.stamp(time - 1)) for each in (seen.track, tracker)
                )
                assert (track is None) == (expected is None)
                if track is not None and expected is not None:
                    np.testing.assert_array_equal(track.state, expected.state)
                    np.testing.assert_array_equal(track.covariance, expected.covariance)
        # The angles of a bearing are those between two samples: it stays where it is.
        assert tracker.at(seen.stamp(189)).azimuth == pytest.approx(0.0, abs=0.1)


def test_the_one_in_front_decides(patient: None, domain: int) -> None:
    """A late bearing whose angles are there waits for the one that came before it."""
    with light(domain) as seen:
        seen.joints(0), seen.joints(10)
        seen.hold(12), seen.hold(5)
        assert seen.released() == []
        seen.joints(15)
        assert seen.released() == [12, 5]


def test_no_bearing_waits_longer_than_it_may(
    monkeypatch: pytest.MonkeyPatch, domain: int
) -> None:
    """It is used with what the angles lead to; without any there is no direction."""
    monkeypatch.setattr(platform, 'PATIENCE', 0)
    with light(domain) as seen:
        seen.hold(0)
        assert seen.released() == []
        seen.joints(0), seen.joints(5)
        seen.hold(8)
        assert seen.released() == [8]
        assert seen.released() == []  # the first one was refused, and does not wait on


def test_the_line_is_bounded(patient: None, domain: int) -> None:
    """Whatever a source sends, the oldest go first."""
    with light(domain) as seen:
        seen.joints(0), seen.joints(5)
        for count in range(MOST_HELD):
            seen.hold(10 + count)
        assert seen.released() == []
        seen.hold(10 + MOST_HELD)
        assert seen.released() == [10]


def test_nothing_is_lost_by_a_change(patient: None, domain: int) -> None:
    """Another filter, a reset of the filter, no joints any more: what waits is used."""
    with light(domain) as seen:
        seen.joints(0), seen.joints(5)
        seen.hold(8), seen.hold(9)
        seen.track.use(seen.tracker())
        seen.track.reset()
        seen.joints(10)
        assert seen.released() == [8, 9]
        seen.hold(12), seen.hold(13)
        seen.platform.change(NO_JOINTS)()
        seen.track.use(seen.tracker())
        assert seen.released() == [12, 13]


def test_what_is_of_another_time_does_not_wait(patient: None, domain: int) -> None:
    """After a jump of the clock later stamps are of before it; a light of no interest is gone."""
    with light(domain) as seen:
        seen.joints(0), seen.joints(5)
        seen.hold(8), seen.hold(50)
        seen.track.forget(seen.stamp(20))
        seen.joints(60)
        assert seen.released() == [8]
        seen.hold(70)
        seen.track.stop()
        seen.joints(80)
        assert seen.released() == []


def test_what_was_seen_before_the_joints_is_no_fault_at_the_start(
    monkeypatch: pytest.MonkeyPatch, domain: int
) -> None:
    """Camera and joints do not begin as one; later on a gap is one."""
    said: list[str] = []
    monkeypatch.setattr(Health, 'fault', lambda health, level, message: said.append(message))
    with light(domain) as seen:
        seen.joints(10), seen.joints(15)
        seen.hold(5)
        assert said == []
        assert seen.released() == []
        monkeypatch.setattr(Health, 'starting', False)
        seen.hold(6)
        assert 'the bearing has no direction in the base: pan of 0.009 s before' in said[0]


@pytest.mark.parametrize('with_joints', [True, False])
def test_innovations_that_are_too_large_may_be_the_joints(
    with_joints: bool, monkeypatch: pytest.MonkeyPatch, domain: int
) -> None:
    """Where they are read it is said what to see to; else they are no part of it."""
    random = np.random.default_rng(3)
    said: list[str] = []
    monkeypatch.setattr(Health, 'fault', lambda health, level, message: said.append(message))
    with light(domain) as seen:
        if not with_joints:
            seen.platform.change(NO_JOINTS)()
        # A filter that expects a light at rest, and bearings far off what they say.
        seen.track.use(Tracker(acceleration=1.0, gate_sigma=100.0, pan_tilt=seen.platform.angles))
        for time in range(0, 1000, 10):
            if with_joints:
                seen.platform.angles.push(seen.stamp(time), 0.0, 0.0)
            azimuth, elevation = random.normal(scale=0.1, size=2)
            seen.take(Bearing(azimuth, elevation, 4e-4 * np.eye(2), seen.stamp(time)))
            seen.released()
        said.clear()
        seen.track.describe()
    assert 'raise acceleration' in said[-1]
    assert ('raise joints.sigma to their error' in said[-1]) is with_joints

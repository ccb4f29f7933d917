"""Two cameras' rays, as two trackers publish them -> positions, and a word for each fault."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, hypot, nan, pi

from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.tracking import CameraPose
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from support.processes import Probe, probe, Process, start

MS = 1_000_000
SIGMA = 0.1  # mrad
START = np.array([15.0, 1.0, 2.5])
VELOCITY = np.array([0.5, 3.0, -1.0])  # m/s: up to 0.2 rad/s
POSES = {
    name: CameraPose(
        np.array([0.0, y, 1.0]), Rotation.from_euler('xyz', [-pi / 2, 0.0, yaw]).as_matrix()
    )
    for name, y, yaw in (('left', 2.0, -pi / 2), ('right', -2.0, -1.7))
}
PARAMETERS = {
    'first__y': 2.0, 'first__z': 1.0, 'second__y': -2.0, 'second__z': 1.0, 'second__yaw': -1.7,
    'light': 'port',
}


def place(stamp_ns: int, begin_ns: int) -> NDArray[np.float64]:
    """Return where the light is at an instant."""
    return START + 1e-9 * (stamp_ns - begin_ns) * VELOCITY


class Cameras:
    """Two cameras that the test plays, before a running triangulator."""

    def __init__(self, node: Probe, process: Process) -> None:
        self.node, self.process = node, process
        self.random = np.random.default_rng(7)
        self.points = node.record(PointStamped, 'target/port/point')
        self.poses = node.record(PoseWithCovarianceStamped, 'target/port/pose')
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        self._rays = {
            name: node.create_publisher(PoseWithCovarianceStamped, f'{name}/target/port/ray', 100)
            for name in POSES
        }
        node.spin_until(lambda: all(each.get_subscription_count() for each in self._rays.values()))
        self.begin_ns = node.get_clock().now().nanoseconds
        node.spin_until(lambda: self.both() or self.points)

    def send(
        self, name: str, stamp_ns: int, off: float = 0.0, variance: float = SIGMA**2
    ) -> None:
        """Publish what a camera sees of the light; `off` by so many mrad upwards."""
        pose = POSES[name]
        x, y, z = pose.rotation.T @ (place(stamp_ns, self.begin_ns) - pose.position)
        azimuth, elevation = 1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)) + off
        noise = self.random.normal(0.0, SIGMA, 2)
        bearing = Bearing(
            azimuth + noise[0], elevation + noise[1], variance * np.eye(2), stamp_ns
        )
        self._rays[name].publish(ray_message(bearing, f'{name}_optical_frame'))

    def both(self, **changed: float) -> None:
        """Publish a ray of each at this instant."""
        stamp_ns = self.node.get_clock().now().nanoseconds
        self.send('left', stamp_ns)
        self.send('right', stamp_ns, **changed)
        self.node.spin(0.03)

    def run(self, seconds: float) -> None:
        """Play two cameras of 20 and 50 Hz that run freely, in real time."""
        begin_ns = self.node.get_clock().now().nanoseconds
        due = sorted(
            [(begin_ns + at, 'left') for at in range(7 * MS, int(seconds * 1e9), 50 * MS)]
            + [(begin_ns + at, 'right') for at in range(0, int(seconds * 1e9), 20 * MS)]
        )
        for stamp_ns, name in due:
            self.node.spin(max(1e-9 * (stamp_ns - self.node.get_clock().now().nanoseconds), 0.0))
            self.send(name, stamp_ns)

    def expect(self, sentence: str, level: bytes, **changed: float) -> None:
        """Send rays until a diagnostic says this; no position is made of them."""
        self.node.settle(0.2)
        self.diagnostics.clear()
        before = len(self.points)

        def said() -> bool:
            self.both(**changed)
            return any(
                sentence in each.status[0].message and each.status[0].level == level
                for each in self.diagnostics
            )

        try:
            self.node.spin_until(said, 6.0)
        except AssertionError:
            words = [each.status[0].message for each in self.diagnostics]
            raise AssertionError(f'{sentence!r} is not in {words}') from None
        assert len(self.points) == before
        assert self.process.running


@pytest.fixture(scope='module')
def cameras(module_domain: int) -> Iterator[Cameras]:
    """Start the node once: surviving everything, one after the other, is the test."""
    with probe(module_domain) as node, start(
        'triangulator', module_domain, **PARAMETERS
    ) as process:
        yield Cameras(node, process)


def test_positions_are_right_within_their_covariance(cameras: Cameras) -> None:
    """Of a light that moves before cameras of 20 and 50 Hz: each with the left one's stamp."""
    cameras.points.clear()
    cameras.poses.clear()
    cameras.run(3.0)
    cameras.node.spin_until(lambda: min(len(cameras.points), len(cameras.poses)) >= 58)
    total = 0.0
    poses = {to_ns(pose.header.stamp): pose for pose in cameras.poses}
    points = {to_ns(point.header.stamp): point for point in cameras.points}
    # A message may be lost on a busy machine, of either topic.
    both = points.keys() & poses.keys()
    assert len(both) >= 56
    for stamp_ns in both:
        point, pose = points[stamp_ns], poses[stamp_ns]
        assert point.header.frame_id == pose.header.frame_id == 'map'
        found = np.array([point.point.x, point.point.y, point.point.z])
        covariance = np.array(pose.pose.covariance).reshape(6, 6)[:3, :3]
        error = found - place(stamp_ns, cameras.begin_ns)
        total += float(error @ np.linalg.solve(covariance, error))
    # It moves evenly: the part of the covariance for what it might have strayed is too much, by
    # less than a half of the right one's.
    low, high = chi2.ppf([0.0005, 0.9995], 3 * len(both))
    assert 0.5 * low < total < high
    status = cameras.diagnostics[-1].status[0]
    assert (status.level, status.message) == (DiagnosticStatus.OK, 'target placed')
    values = {each.key: each.value for each in status.values}
    assert float(values['time between the rays that are interpolated (s)']) == 0.02
    assert ' +- ' in values['x (m)']


@pytest.mark.parametrize('variance', [nan, 0.0])
def test_a_covariance_that_cannot_be_is_named(cameras: Cameras, variance: float) -> None:
    """With the topic it came on."""
    cameras.expect(
        '/right/target/port/ray: the covariance of the bearing' if variance == 0.0
        else '/right/target/port/ray: the bearing is',
        DiagnosticStatus.ERROR,
        variance=variance,
    )


def test_rays_that_do_not_meet_are_named(cameras: Cameras) -> None:
    """One is 2 mrad too high."""
    cameras.expect('the rays do not meet: chi-square is', DiagnosticStatus.WARN, off=2.0)


def test_a_silent_camera_is_named(cameras: Cameras) -> None:
    """And the word ends when it is back."""
    def said() -> bool:
        cameras.send('left', cameras.node.get_clock().now().nanoseconds)
        cameras.node.spin(0.1)
        message = cameras.diagnostics[-1].status[0].message
        return '/right/target/port/ray is silent and /left/target/port/ray is not' in message

    cameras.node.spin_until(said)
    cameras.node.spin_until(
        lambda: cameras.both()
        or cameras.diagnostics[-1].status[0].message == 'target placed'
    )


def test_stamps_of_different_clocks_are_named(cameras: Cameras) -> None:
    """One machine is an hour behind; positions are back when it is set."""
    def said() -> bool:
        now_ns = cameras.node.get_clock().now().nanoseconds
        cameras.send('left', now_ns)
        cameras.send('right', now_ns - 3600 * 1000 * MS)
        cameras.node.spin(0.05)
        message = cameras.diagnostics[-1].status[0].message
        return (
            'the rays on /right/target/port/ray are 3600.0 s older as they come than those on '
            '/left/target/port/ray: they have stamps of different clocks'
        ) in message

    cameras.node.spin_until(said)
    before = len(cameras.points)
    cameras.node.spin_until(lambda: cameras.both() or len(cameras.points) > before + 3)


def test_parallel_rays_and_a_missing_baseline_are_named(cameras: Cameras) -> None:
    """The cameras are told to stand 1 mm apart, and then at one place."""
    def put(y: float) -> None:
        assert cameras.node.set_parameter('triangulator', 'second.y', y).successful

    assert cameras.node.set_parameter('triangulator', 'second.yaw', -pi / 2).successful
    try:
        before = POSES['right']
        POSES['right'] = CameraPose(np.array([0.0, 1.999, 1.0]), POSES['left'].rotation)
        put(1.999)
        cameras.expect('no position: the rays are parallel', DiagnosticStatus.WARN)
        put(2.0)
        cameras.expect('both cameras are at the same place', DiagnosticStatus.ERROR)
        cameras.diagnostics.clear()  # and also while no ray arrives
        cameras.node.spin_until(lambda: any(
            'both cameras are at the same place' in each.status[0].message
            for each in cameras.diagnostics
        ))
    finally:
        POSES['right'] = before


@pytest.mark.parametrize('parameters, sentence', [
    ({'second__namespace': 'left'}, 'are both that of /left/target/ray'),
    ({'second__namespace': 'my camera'}, "parameter 'second.namespace': "),
    ({'light': 'a/b'}, "'a/b' is no name of a light"),
    ({'first__roll': 90.0}, "'first.roll' is 90.0; it must be a number with a point from -3.14"),
])
def test_what_cannot_be_is_said(domain: int, parameters: dict[str, object], sentence: str) -> None:
    """Exit code 2 with a sentence."""
    with start('triangulator', domain, **parameters) as process:
        assert process.wait() == 2
        assert sentence in process.output

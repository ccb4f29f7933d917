"""Cameras' rays, as their trackers publish them -> positions, and a word for each fault."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import atan2, hypot, nan, pi
from pathlib import Path
from typing import Any

from blob_tracker.__main__ import main
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.simulation.waved_light import RigCamera
from blob_tracker.tracking import CameraPose
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from support.bags_of_rays import recorded_rays
from support.processes import Probe, probe, Process, start

Array = NDArray[np.float64]
MS = 1_000_000
SIGMA = 0.1  # mrad
START = np.array([15.0, 1.0, 2.5])
VELOCITY = np.array([0.5, 3.0, -1.0])  # m/s: up to 0.2 rad/s
POSES = {
    name: CameraPose(
        np.array(place), Rotation.from_euler('xyz', [-pi / 2, 0.0, yaw]).as_matrix()
    )
    for name, place, yaw in (
        ('left', [0.0, 2.0, 1.0], -pi / 2), ('right', [0.0, -2.0, 1.0], -1.7),
        ('top', [1.0, 0.0, 4.0], -1.5),
    )
}
PARAMETERS = {
    'cameras': '[left, right, top]', 'light': 'port',
    'acceleration': 30.0,  # mrad/s^2: it moves evenly
    'poses__left__y': 2.0, 'poses__left__z': 1.0,
    'poses__right__y': -2.0, 'poses__right__z': 1.0, 'poses__right__yaw': -1.7,
    'poses__top__x': 1.0, 'poses__top__z': 4.0, 'poses__top__yaw': -1.5,
}
EVERY = tuple(POSES)
PERIODS = {'left': 50, 'right': 20, 'top': 30}  # ms


def place(stamp_ns: int, begin_ns: int) -> Array:
    """Return where the light is at an instant: it stands at first, and then moves for 4 s."""
    return START + min(max(1e-9 * (stamp_ns - begin_ns), 0.0), 4.0) * VELOCITY


class Cameras:
    """Cameras that the test plays, before a running triangulator."""

    def __init__(
        self, node: Probe, process: Process, light: str = 'port/',
        poses: dict[str, CameraPose] = POSES,
    ) -> None:
        self.node, self.process, self.true = node, process, dict(poses)
        self.random = np.random.default_rng(7)
        self.points = node.record(PointStamped, f'target/{light}point')
        self.poses = node.record(PoseWithCovarianceStamped, f'target/{light}pose')
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        self._rays = {
            name: node.create_publisher(
                PoseWithCovarianceStamped, f'{name}/target/{light}ray', 100)
            for name in poses
        }
        node.spin_until(lambda: all(each.get_subscription_count() for each in self._rays.values()))
        self.begin_ns = node.get_clock().now().nanoseconds

    def send(
        self, name: str, stamp_ns: int, off: float = 0.0, variance: float = SIGMA**2,
        frame_id: str = '',
    ) -> None:
        """Publish what a camera sees of the light; `off` by so many mrad upwards."""
        pose = self.true[name]
        x, y, z = pose.rotation.T @ (place(stamp_ns, self.begin_ns) - pose.position)
        azimuth, elevation = 1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)) + off
        noise = self.random.normal(0.0, SIGMA, 2)
        bearing = Bearing(
            azimuth + noise[0], elevation + noise[1], variance * np.eye(2), stamp_ns
        )
        self._rays[name].publish(ray_message(bearing, frame_id or f'{name}_optical_frame'))

    def together(self, names: Sequence[str] = EVERY, odd: str = '', **changed: Any) -> None:
        """Publish a ray of each at this instant, one of them changed."""
        stamp_ns = self.node.get_clock().now().nanoseconds
        for name in names:
            self.send(name, stamp_ns, **(changed if name == odd else {}))
        self.node.spin(0.03)

    def run(self, seconds: float, names: Sequence[str] = EVERY, **off: float) -> None:
        """Play cameras of 20, 50 and 33 Hz that run freely, in real time."""
        self.begin_ns = begin_ns = self.node.get_clock().now().nanoseconds
        due = sorted(
            (begin_ns + at, name) for number, name in enumerate(names)
            for at in range((7 - 3 * number) * MS, int(seconds * 1e9), PERIODS[name] * MS)
        )
        for stamp_ns, name in due:
            self.node.spin(max(1e-9 * (stamp_ns - self.node.get_clock().now().nanoseconds), 0.0))
            self.send(name, stamp_ns, off.get(name, 0.0))

    def played(self, seconds: float, least: int, **given: Any) -> list[float]:
        """Play the cameras; return each position's squared error over its covariance."""
        self.node.settle(0.2)
        self.points.clear()
        self.poses.clear()
        self.run(seconds, **given)
        self.node.spin_until(lambda: min(len(self.points), len(self.poses)) >= least)
        poses = {to_ns(pose.header.stamp): pose for pose in self.poses}
        points = {to_ns(point.header.stamp): point for point in self.points}
        # A message may be lost on a busy machine, of either topic.
        both = {
            stamp_ns for stamp_ns in points.keys() & poses.keys()
            if stamp_ns >= self.begin_ns  # the last rays before waited for those
        }
        assert len(both) >= least - 2
        squared = []
        for stamp_ns in both:
            point, pose = points[stamp_ns], poses[stamp_ns]
            assert point.header.frame_id == pose.header.frame_id == 'map'
            found = np.array([point.point.x, point.point.y, point.point.z])
            covariance = np.array(pose.pose.covariance).reshape(6, 6)[:3, :3]
            error = found - place(stamp_ns, self.begin_ns)
            squared.append(float(error @ np.linalg.solve(covariance, error)))
        return squared

    def message(self) -> str:
        """Return what the last diagnostics say; empty where there are none yet."""
        return self.diagnostics[-1].status[0].message if self.diagnostics else ''

    def values(self) -> dict[str, str]:
        """Return what the last diagnostics show."""
        return {each.key: each.value for each in self.diagnostics[-1].status[0].values}

    def expect(
        self, sentence: str, level: bytes, names: Sequence[str] = EVERY, silent: bool = True,
        **changed: Any,
    ) -> None:
        """Send rays until a diagnostic says this; no position is made of them if it is silent."""
        self.node.settle(0.2)
        self.diagnostics.clear()
        before = len(self.points)

        def said() -> bool:
            self.together(names, **changed)
            return any(
                sentence in each.status[0].message and each.status[0].level == level
                for each in self.diagnostics
            )

        try:
            self.node.spin_until(said)
        except AssertionError:
            words = [each.status[0].message for each in self.diagnostics]
            raise AssertionError(f'{sentence!r} is not in {words}') from None
        assert (len(self.points) == before) is silent
        assert self.process.running


def probable(squared: Sequence[float]) -> bool:
    """Tell whether errors are those of their covariances; neighbours share rays."""
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], 3 * len(squared))
    return bool(0.8 * low < sum(squared) < 1.2 * high)


@pytest.fixture(scope='module')
def cameras(module_domain: int) -> Iterator[Cameras]:
    """Start the node once: surviving everything, one after the other, is the test."""
    with probe(module_domain) as node, start(
        'triangulator', module_domain, **PARAMETERS
    ) as process:
        played = Cameras(node, process)
        node.spin_until(lambda: played.together() or played.points)
        yield played


def test_positions_are_right_within_their_covariance(cameras: Cameras) -> None:
    """Of a light that moves before cameras of 20, 50 and 33 Hz: each with the left one's stamp."""
    squared = cameras.played(3.0, 58)
    assert len(squared) <= 62  # two before its first ray are of the others
    assert probable(squared)
    status = cameras.diagnostics[-1].status[0]
    assert (status.level, status.message) == (DiagnosticStatus.OK, 'target placed')
    values = cameras.values()
    assert 0.02 <= float(values['time between the rays that are interpolated (s)']) <= 0.031
    assert ' +- ' in values['x (m)']
    assert values['placed by'] == 'left, right, top'


def test_any_two_of_them_are_enough(cameras: Cameras) -> None:
    """The one that is out of sight is waited for no longer, and who it is is told."""
    for names, least in (('right', 'top'), 85), (('left', 'top'), 35):
        cameras.node.settle(0.5)
        assert probable(cameras.played(2.5, least, names=names))
        cameras.node.spin_until(
            lambda: cameras.together(names)
            or cameras.values()['placed by'] == ', '.join(names)
            and cameras.values()['silent cameras'] == ({*EVERY} - {*names}).pop()
        )
        status = cameras.diagnostics[-1].status[0]
        assert (status.level, status.message) == (DiagnosticStatus.OK, 'target placed')


def test_a_camera_that_sees_another_light_is_named(cameras: Cameras) -> None:
    """The right one, by 6 mrad; the position is that of the two others."""
    cameras.together()
    squared = cameras.played(2.0, 36, right=6.0)
    assert probable(squared)
    cameras.expect(
        'the ray of right passes the others by, ', DiagnosticStatus.WARN, silent=False,
        odd='right', off=6.0,
    )
    cameras.node.spin_until(
        lambda: cameras.together(odd='right', off=6.0)
        or cameras.values()['placed by'] == 'left, top'
    )


@pytest.mark.parametrize('variance', [nan, 0.0])
def test_a_covariance_that_cannot_be_is_named(cameras: Cameras, variance: float) -> None:
    """With the topic it came on."""
    cameras.expect(
        '/right/target/port/ray: the covariance of the bearing' if variance == 0.0
        else '/right/target/port/ray: the bearing is',
        DiagnosticStatus.ERROR, names=('left', 'right'), odd='right', variance=variance,
    )


def test_rays_that_do_not_meet_are_named(cameras: Cameras) -> None:
    """Of two cameras one is 6 mrad too high: which of them is not told."""
    cameras.expect(
        'the rays of left, right do not meet: chi-square is', DiagnosticStatus.WARN,
        names=('left', 'right'), odd='right', off=6.0,
    )


def test_rays_of_another_camera_are_named(cameras: Cameras) -> None:
    """By their frame; they are left out."""
    cameras.expect(
        "/right/target/port/ray: the ray is in the frame 'front' and the first was in "
        "'right_optical_frame': it is of another camera, and left out",
        DiagnosticStatus.ERROR, names=('left', 'right'), odd='right', frame_id='front',
    )


def test_silent_cameras_are_named(cameras: Cameras) -> None:
    """And the word ends when they are back."""
    def said() -> bool:
        cameras.send('left', cameras.node.get_clock().now().nanoseconds)
        cameras.node.spin(0.1)
        return (
            '/right/target/port/ray, /top/target/port/ray are silent and /left/target/port/ray is '
            'not'
        ) in cameras.message()

    cameras.node.spin_until(said)
    cameras.node.spin_until(
        lambda: cameras.together()
        or cameras.message() == 'target placed'
    )


@pytest.mark.parametrize('names', [('left', 'right'), EVERY])
def test_stamps_of_different_clocks_are_named(cameras: Cameras, names: tuple[str, ...]) -> None:
    """One machine is an hour behind: of three the others go on; all do when it is set."""
    cameras.node.settle(1.2)  # in which those that are not played are forgotten

    def said() -> bool:
        now_ns = cameras.node.get_clock().now().nanoseconds
        for name in names:
            cameras.send(name, now_ns - (3600 * 1000 * MS if name == 'right' else 0))
        cameras.node.spin(0.05)
        others = ', '.join(f'/{name}/target/port/ray' for name in names if name != 'right')
        return (
            f'the rays on /right/target/port/ray are 3600.0 s older as they come than those on '
            f'{others}: they have stamps of different clocks'
        ) in cameras.message()

    before = len(cameras.points)
    cameras.node.spin_until(said)
    assert (len(cameras.points) > before) is (len(names) > 2)
    before = len(cameras.points)
    cameras.node.spin_until(lambda: cameras.together() or len(cameras.points) > before + 3)


def test_parallel_rays_and_a_missing_baseline_are_named(cameras: Cameras) -> None:
    """The cameras are told to stand 1 mm apart, and then at one place."""
    def put(y: float) -> None:
        assert cameras.node.set_parameter('triangulator', 'poses.right.y', y).successful

    assert cameras.node.set_parameter('triangulator', 'poses.right.yaw', -pi / 2).successful
    try:
        cameras.true['right'] = CameraPose(np.array([0.0, 1.999, 1.0]), POSES['left'].rotation)
        put(1.999)
        pair = 'left', 'right'
        cameras.expect('no position: the rays are parallel', DiagnosticStatus.WARN, pair)
        put(2.0)
        cameras.expect('left and right are at the same position', DiagnosticStatus.ERROR, pair)
        cameras.diagnostics.clear()  # and also while no ray arrives
        cameras.node.spin_until(lambda: any(
            'left and right are at the same position' in each.status[0].message
            for each in cameras.diagnostics
        ))
    finally:
        cameras.true['right'] = POSES['right']


def test_a_camera_without_a_pose_and_one_that_never_comes_are_named(domain: int) -> None:
    """The others go on without them; a pose may still be given."""
    parameters = {name: value for name, value in PARAMETERS.items() if 'top' not in name}
    parameters['cameras'] = '[left, right, top, rear]'
    poses = {name: POSES[name] for name in ('left', 'right')}
    with probe(domain) as node, start('triangulator', domain, **parameters) as process:
        played = Cameras(node, process, poses=poses)

        def said(*sentences: str) -> bool:
            played.together(('left', 'right'))
            return any(
                all(each in array.status[0].message for each in sentences)
                for array in played.diagnostics
            )

        node.spin_until(lambda: said(
            'top has no pose and is not used; set poses.top.x', 'rear has no pose'))
        for name in ('top', 'rear'):
            away = 0.1 * len(name)
            assert node.set_parameter('triangulator', f'poses.{name}.x', away).successful
        played.diagnostics.clear()
        node.spin_until(lambda: said(
            'nothing has ever come on /top/target/port/ray',
            'nothing has ever come on /rear/target/port/ray'))
        assert played.points
        assert process.running


def test_what_a_first_position_needs_is_loaded_before_its_rays_come(domain: int) -> None:
    """Half a second, in which they would grow old."""
    with probe(domain) as node, start('triangulator', domain) as process:
        node.spin_until(lambda: node.count_subscribers('left/target/ray') > 0)
        assert '/scipy/special/' in process.libraries()


def test_what_calibrate_rig_writes_is_what_the_node_takes(domain: int, tmp_path: Path) -> None:
    """Three cameras and a wand; the positions are as far off as their covariance says."""
    rig = {
        'left': RigCamera((-1.0, 0.0, 0.0)), 'right': RigCamera((1.0, 0.0, 0.0), offset=0.012),
        'robot/top': RigCamera((0.0, -1.5, 1.0), roll=3.0),
    }
    bag = recorded_rays(tmp_path / 'bag', 0.5, ('red', 'blue'), rig)
    out = tmp_path / 'rig.yaml'
    assert main(list(map(str, (
        'calibrate', 'rig', bag, '--cameras', *rig, '--wand', 'red', 'blue', 0.5, 1e-4,
        '--out', out,
    )))) == 0
    first = rig['left']
    upright = Rotation.from_euler('xyz', [-pi / 2, 0.0, -pi / 2]).as_matrix()
    poses = {
        name: CameraPose(
            upright @ first.rotation.T @ np.subtract(each.position, first.position),
            upright @ first.rotation.T @ each.rotation,
        )
        for name, each in rig.items()
    }
    with probe(domain) as node, start(
        'triangulator', domain, '--params-file', str(out),
    ) as process:
        played = Cameras(node, process, '', poses)
        node.spin_until(lambda: played.together(list(rig)) or played.points)
        node.spin_until(lambda: played.together(list(rig)) or len(played.poses) > 20)
    squared, deviations = [], []
    for pose in played.poses:
        at = pose.pose.pose.position
        error = np.array([at.x, at.y, at.z]) - place(to_ns(pose.header.stamp), played.begin_ns)
        covariance = np.array(pose.pose.covariance).reshape(6, 6)[:3, :3]
        squared.append(float(error @ np.linalg.solve(covariance, error)))
        deviations.append(np.sqrt(covariance.trace()))
    # What the calibration errs by is in each of them, so that they count as one, not as twenty.
    assert 0.5 < np.mean(squared) / 3.0 < chi2.isf(1e-4, 3) / 3.0 + 1.0
    assert max(deviations) < 0.2  # m, at 15 m


@pytest.mark.parametrize('parameters, sentence', [
    ({'cameras': '[left]'}, "parameter 'cameras' is [left]; a position takes two or more cameras"),
    ({'cameras': '[left, right, left]'}, 'with left twice'),
    ({'cameras': '[left, my camera]'}, "parameter 'cameras': "),
    ({'cameras': 'left'}, 'must be a list of strings, as [left,right]'),
    ({'first__y': 0.5}, "no parameter 'first.y'; it is 'poses.left.y' now"),
    ({'second__namespace': 'top'}, "no parameter 'second.namespace'; it is 'cameras' now"),
    ({'poses__top__x': 1.0}, "'poses.top.x'; cameras is [left, right], and each of these"),
    ({'gaet': 4.0}, "no parameter 'gaet'; did you mean 'gate'?"),
    ({'light': 'a/b'}, "'a/b' is not a name for a light"),
    ({'pose_covariance': '[1.0, 2.0]'}, 'has 2 numbers; for 2 cameras it must be 78'),
    ({'pose_covariance': str([-1.0] * 78)}, 'is not a covariance'),
    ({'poses__left__roll': 90.0},
     "'poses.left.roll' is 90.0; it must be a number with a point from -3.14"),
])
def test_what_cannot_be_is_said(domain: int, parameters: dict[str, object], sentence: str) -> None:
    """Exit code 2 with a sentence."""
    with start('triangulator', domain, **parameters) as process:
        assert process.wait() == 2
        assert sentence in process.output

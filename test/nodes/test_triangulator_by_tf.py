"""The triangulator whose cameras TF places, one of them on a pan/tilt that turns."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, hypot, pi, sin
import os

from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.transforms import Transform, TransformTree
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
import pytest
from scipy.stats import chi2
from support.processes import Probe, probe, Process, start
from support.slowness import slowness
from support.transforms import Broadcaster, OPTICAL, transform

pytestmark = pytest.mark.usefixtures('tf2_messages')

MS = 1_000_000
SIGMA = 0.1  # mrad
LIGHT = np.array([15.0, 1.0, 2.5])
LEFT = 'map', transform(0.0, 2.0, 1.0, *OPTICAL)
MAST = 'map', transform(1.0, -2.0, 1.0, yaw=0.1)
RIGHT = 'pan', transform(0.05, 0.0, 0.1, *OPTICAL)
TF_MS, LEFT_MS, RIGHT_MS = 10, 50, 20


def pan(stamp_ns: int) -> tuple[str, Transform]:
    """Return how the pan stands: up to 0.9 rad/s and 2.8 rad/s^2."""
    return 'mast', transform(yaw=0.3 * sin(pi * 1e-9 * (stamp_ns % 10**12)))


class Rig:
    """Two cameras and TF that the test plays, before a running triangulator."""

    def __init__(self, node: Probe, process: Process, tf: Broadcaster) -> None:
        self.node, self.process, self.tf = node, process, tf
        self.random = np.random.default_rng(7)
        self.poses = node.record(PoseWithCovarianceStamped, 'target/pose')
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        self._rays = {
            name: node.create_publisher(PoseWithCovarianceStamped, f'{name}/target/ray', 100)
            for name in ('left', 'right')
        }
        node.spin_until(lambda: all(each.get_subscription_count() for each in (
            *self._rays.values(), tf.moving, tf.static
        )))
        node.spin_until(lambda: node.count_publishers('/target/pose'))
        self.run(0.1)
        node.spin_until(lambda: self.run(0.1) or self.poses)

    def now_ns(self) -> int:
        """Return ROS time, ns."""
        return self.node.get_clock().now().nanoseconds

    def see(self, name: str, stamp_ns: int, frame_id: str = '') -> None:
        """Publish what a camera sees of the light."""
        frame_id = frame_id or f'{name}_optical'
        world = TransformTree()
        for frame, (parent, how) in {
            'left_optical': LEFT, 'mast': MAST, 'right_optical': RIGHT, 'pan': pan(stamp_ns),
        }.items():
            world.put_static(frame, parent, how)
        camera = world.lookup(f'{name}_optical', 'map', stamp_ns).transform
        x, y, z = camera.matrix.T @ (LIGHT - camera.translation)
        noise = self.random.normal(0.0, SIGMA, 2)
        self._rays[name].publish(ray_message(Bearing(
            1e3 * atan2(x, z) + noise[0], 1e3 * atan2(-y, hypot(x, z)) + noise[1],
            SIGMA**2 * np.eye(2), stamp_ns,
        ), frame_id))

    def run(
        self, seconds: float, late_ms: int = 0, moves: bool = True, behind_ns: int = 0,
        frame_id: str = '', tf_ms: int = TF_MS,
    ) -> None:
        """Play in real time; /tf so late or seldom, not at all, or by a clock that is behind."""
        begin_ns, end = self.now_ns(), int(1e9 * seconds)
        due = [(at, at, 'left') for at in range(7 * MS, end, LEFT_MS * MS)]
        due += [(at, at, 'right') for at in range(0, end, RIGHT_MS * MS)]
        if moves:
            due += [(at + late_ms * MS, at, 'pan') for at in range(-30 * MS, end, tf_ms * MS)]
        for when, at, what in sorted(due):
            stamp_ns = begin_ns + at
            self.node.spin(max(1e-9 * (begin_ns + when - self.now_ns()), 0.0))
            if what == 'pan':
                self.tf.move(stamp_ns - behind_ns, pan=pan(stamp_ns))
            else:
                self.see(what, stamp_ns, frame_id if what == 'left' else '')

    def expect(self, *words: str, seconds: float = 0.2, **options: object) -> None:
        """Play until a diagnostic warns of all this; no position is made meanwhile."""
        self.node.settle(0.2)
        self.diagnostics.clear()
        before = len(self.poses)

        def said() -> bool:
            self.run(seconds, **options)  # type: ignore[arg-type]
            return any(
                each.status[0].level == DiagnosticStatus.WARN
                and all(word in each.status[0].message for word in words)
                for each in self.diagnostics
            )

        try:
            self.node.spin_until(said)
        except AssertionError:
            found = [each.status[0].message for each in self.diagnostics]
            raise AssertionError(f'{words!r} is not in {found}') from None
        assert len(self.poses) == before
        assert self.process.running

    def values(self) -> dict[str, str]:
        """Return the newest numbers of the diagnostics."""
        self.diagnostics.clear()
        self.node.spin_until(lambda: self.diagnostics)
        return {each.key: each.value for each in self.diagnostics[-1].status[0].values}


@pytest.fixture(scope='module')
def rig(module_domain: int) -> Iterator[Rig]:
    """Start the node once; what is static was said before it came."""
    with probe(module_domain) as node:
        tf = Broadcaster(node)
        tf.hold(mast=MAST)
        tf.hold(left_optical=LEFT, right_optical=RIGHT)
        with start('triangulator', module_domain, use_tf='true') as process:
            yield Rig(node, process, tf)


@pytest.mark.parametrize('late_ms', [0, 60])
def test_positions_are_right_within_their_covariance(rig: Rig, late_ms: int) -> None:
    """The camera turns by 18 mrad from ray to ray, and TF may come when they are long there."""
    rig.node.settle(0.2)
    rig.poses.clear()
    rig.run(1.3, late_ms=late_ms)
    rig.run(0.1)  # for the last of them
    rig.node.spin_until(lambda: len(rig.poses) > 24)
    total, count = 0.0, 0
    for message in rig.poses:
        assert message.header.frame_id == 'map'
        place = message.pose.pose.position
        error = np.array([place.x, place.y, place.z]) - LIGHT
        covariance = np.array(message.pose.covariance).reshape(6, 6)[:3, :3]
        total += float(error @ np.linalg.solve(covariance, error))
        count += 1
    stamps = [to_ns(each.header.stamp) for each in rig.poses]
    assert stamps == sorted(stamps)
    # The light is at rest: the part of the covariance for what it might have strayed is too much.
    low, high = chi2.ppf([0.0005, 0.9995], 3 * count)
    assert 0.5 * low < total < high
    values = rig.values()
    assert values['place of right'] == 'by TF'
    assert values.get('rays without a transform', '0') == '0'


def test_how_long_rays_wait_is_shown(rig: Rig) -> None:
    """The transforms come 60 ms after their stamps, and rays at once."""
    rig.run(1.3, late_ms=60)
    waited = float(rig.values()['longest wait for transforms (ms)'])
    assert 40.0 < waited < 100.0 * slowness()


def test_transforms_that_end_are_named(rig: Rig) -> None:
    """And positions are back when they are."""
    rig.expect(
        "/right/target/ray: ray left out: the newest transform of 'pan' in 'mast' is",
        moves=False,
    )
    before = len(rig.poses)
    rig.node.spin_until(lambda: rig.run(0.1) or len(rig.poses) > before)


def test_transforms_that_come_too_seldom_are_named(rig: Rig) -> None:
    """Between two of them the camera pans by up to 0.27 rad, and nobody knows how."""
    rig.expect(
        "/right/target/ray: ray left out: transforms of 'pan' in 'mast' are 0.300 s apart, and "
        'may be 0.25 s; publish it more often',
        seconds=0.9, tf_ms=300,
    )
    before = len(rig.poses)
    rig.node.spin_until(lambda: rig.run(0.1) or len(rig.poses) > before)


def test_transforms_of_another_clock_are_named(rig: Rig) -> None:
    """They are an hour behind, and come all the time."""
    rig.expect(
        "'pan' in 'mast' is 3599.", 'their stamps are of another clock',
        behind_ns=3600 * 10**9,
    )
    before = len(rig.poses)
    rig.node.spin_until(lambda: rig.run(0.1) or len(rig.poses) > before)


def test_a_frame_of_which_nothing_was_said_is_named(rig: Rig) -> None:
    """With what would connect it, and all that is known."""
    rig.expect(
        "/left/target/ray: ray left out: nothing was said of 'camera'; publish where 'camera' "
        "lies in 'map'", 'known are map > left_optical, mast; mast > pan; pan > right_optical',
        frame_id='camera',
    )


def test_parameters_win_and_a_difference_is_told(rig: Rig) -> None:
    """By 0.1 m, of a camera whose place is given too."""
    for name, value in zip(
        ('y', 'z', 'roll', 'pitch', 'yaw'), (2.1, 1.0, *OPTICAL), strict=True
    ):
        done = rig.node.set_parameter('triangulator', f'poses.left.{name}', float(value))
        assert done.successful
    words = "the parameters have 'left_optical' 0.100 m and 0.0 mrad from where TF has it"
    rig.diagnostics.clear()
    rig.node.spin_until(lambda: rig.run(0.1) or any(
        words in each.status[0].message for each in rig.diagnostics
    ))
    assert rig.values()['place of left'] == 'by parameters'


def test_without_the_messages_that_is_said(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit code 2 with what to do; without the parameter nothing is missed."""
    paths = os.environ['PYTHONPATH'].split(os.pathsep)
    monkeypatch.setenv(
        'PYTHONPATH', os.pathsep.join(path for path in paths if 'tf2_msgs' not in path)
    )
    with start('triangulator', domain, use_tf='true') as process:
        if process.wait() != 2:
            pytest.skip('tf2_msgs is installed')
        assert "parameter 'use_tf' asks for TF, and tf2_msgs cannot be imported" in process.output
        assert 'sudo apt install ros-jazzy-tf2-msgs' in process.output

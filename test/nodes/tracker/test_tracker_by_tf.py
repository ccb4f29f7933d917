"""The tracker whose camera TF turns with the pan/tilt, beside one that hears the joints."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, hypot, pi, sin
from pathlib import Path

from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.ros.messages.track import to_track
from blob_tracker.tracking import Track
from blob_tracker.tracking.rotation import pan_tilt
from blob_tracker.transforms import Transform
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Imu, JointState
from support.processes import Probe, probe, start
from support.transforms import Broadcaster, transform
from support.urdf import frames, read_urdf

pytestmark = pytest.mark.usefixtures('tf2_messages')

MS = 1_000_000
SIGMA = 0.02  # mrad
CAMERA, BASE = 'camera_optical_frame', 'base_optical_frame'
JOINTS = read_urdf(Path(__file__).parents[3] / 'examples' / 'pan_tilt.urdf')[1]
# Of the IMU in base_link, as it was screwed on; and of the base in it, as the parameters have it.
IMU = transform(-0.05, 0.0, 0.02, 0.3, -0.2, 1.0)
MOUNT = Rotation.from_quat(IMU.rotation).inv() * Rotation.from_euler(
    'xyz', [-pi / 2, 0.0, -pi / 2]
)
LIGHT = np.array([3.0, -1.0, 40.0])  # in the base, at rest against the ground
JOINTS_MS, IMU_MS, RAYS_MS = 10, 5, 33
LATENCY_MS = 25  # from the stamp of a ray to its arrival


def seconds(stamp_ns: int) -> float:
    """Return the time within a long while, s."""
    return 1e-9 * (stamp_ns % 10**12)


def angles(stamp_ns: int) -> dict[str, float]:
    """Return how the joints stand, rad: up to 1 rad/s."""
    time = seconds(stamp_ns)
    return {'pan': 0.3 * sin(3.3 * time), 'tilt': 0.1 * sin(2.0 * time + 1.0)}


def yaw(stamp_ns: int) -> float:
    """Return how the boat is turned to the right, rad: up to 0.2 rad/s."""
    return 0.2 * sin(seconds(stamp_ns))


class Boat:
    """Rays, joints, a gyro and TF that the test plays to two trackers."""

    def __init__(self, node: Probe, tf: Broadcaster) -> None:
        self.node, self.tf = node, tf
        self._rays = [
            node.create_publisher(PoseWithCovarianceStamped, f'{name}/target/ray', 100)
            for name in ('by_joints', 'by_tf')
        ]
        self._imu = node.create_publisher(Imu, 'imu', 100)
        self._joints = node.create_publisher(JointState, 'joint_states', 100)
        self.tracks = {
            name: node.record(Odometry, f'{name}/target/track') for name in ('by_joints', 'by_tf')
        }
        self.predictions = node.record(Vector3Stamped, 'by_tf/target/bearing_predicted')
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        node.spin_until(lambda: all(each.get_subscription_count() for each in (
            *self._rays, self._joints, tf.moving, tf.static
        )) and self._imu.get_subscription_count() == 2)
        node.spin_until(lambda: all(
            node.count_publishers(f'/{name}/target/track') for name in self.tracks
        ))

    def now_ns(self) -> int:
        """Return ROS time, ns."""
        return self.node.get_clock().now().nanoseconds

    def run(self, seconds: float, tf_late_ms: int = 0, moves: bool = True) -> list[int]:
        """Play in real time, /tf so late or not at all; return the stamps of the rays."""
        begin_ns, end, random = self.now_ns(), int(1e9 * seconds), np.random.default_rng(5)
        due = [(at, at, 'joints') for at in range(-60 * MS, end, JOINTS_MS * MS)]
        due += [(at, at, 'imu') for at in range(-60 * MS, end, IMU_MS * MS)]
        due += [
            (at + LATENCY_MS * MS, at, 'ray') for at in range(0, end - 40 * MS, RAYS_MS * MS)
        ]
        if moves:
            due += [
                (at + tf_late_ms * MS, at, 'tf') for at in range(-60 * MS, end, JOINTS_MS * MS)
            ]
        stamps = []
        for when, at, what in sorted(due):
            stamp_ns = begin_ns + at
            self.node.spin(max(1e-9 * (begin_ns + when - self.now_ns()), 0.0))
            if what == 'tf':
                self.tf.move(stamp_ns, **frames(JOINTS, angles(stamp_ns), fixed=False))
            elif what == 'joints':
                message = JointState(name=list(angles(0)), position=angles(stamp_ns).values())
                message.header.stamp = from_ns(stamp_ns)
                self._joints.publish(message)
            elif what == 'imu':
                self._gyro(stamp_ns)
            else:
                stamps.append(stamp_ns)
                self._see(stamp_ns, random)
        self.node.settle(0.2)
        return stamps

    def _gyro(self, stamp_ns: int) -> None:
        """Publish how the boat turns, as the IMU has it."""
        message = Imu()
        message.header.stamp, message.header.frame_id = from_ns(stamp_ns), 'imu_link'
        rate = MOUNT.apply([0.0, 0.2 * np.cos(seconds(stamp_ns)), 0.0])
        vector = message.angular_velocity
        vector.x, vector.y, vector.z = rate
        self._imu.publish(message)

    def _see(self, stamp_ns: int, random: np.random.Generator) -> None:
        """Publish the ray of the light to both trackers."""
        x, y, z = pan_tilt(*angles(stamp_ns).values()).T @ in_base(stamp_ns)
        noise = random.normal(0.0, SIGMA, 2)
        message = ray_message(Bearing(
            1e3 * atan2(x, z) + noise[0], 1e3 * atan2(-y, hypot(x, z)) + noise[1],
            SIGMA**2 * np.eye(2), stamp_ns,
        ), CAMERA)
        for each in self._rays:
            each.publish(message)

    def tracked(self, name: str) -> dict[int, Track]:
        """Return the tracks of one tracker by their stamps, ns."""
        return {to_ns(each.header.stamp): to_track(each) for each in self.tracks[name]}

    def says(self, *words: str) -> bool:
        """Tell whether a diagnostic of the tracker by TF has said all this."""
        return any(
            status.name.startswith('/by_tf') and all(word in status.message for word in words)
            for array in self.diagnostics for status in array.status
        )

    def values(self) -> dict[str, str]:
        """Return the newest numbers of the tracker by TF."""
        return {
            value.key: value.value for array in self.diagnostics for status in array.status
            if status.name.startswith('/by_tf') for value in status.values
        }


def in_base(stamp_ns: int) -> np.ndarray:
    """Return where the light is in the base, which the boat turns to the right."""
    return Rotation.from_rotvec([0.0, -yaw(stamp_ns), 0.0]).apply(LIGHT)


def in_namespace(name: str) -> list[str]:
    """Return the words that start a tracker in a namespace, with the topics of all."""
    return [
        '-r', f'__ns:=/{name}', '-r', 'imu:=/imu', '-r', 'joint_states:=/joint_states',
    ]


@pytest.fixture(scope='module')
def boat(module_domain: int) -> Iterator[Boat]:
    """Start both once; what is static was said before they came."""
    roll, pitch, mounted_yaw = MOUNT.as_euler('xyz')
    common = {'imu__enabled': 'true', 'prediction_rate': 0.0, 'servo_delay': 0.02}
    with probe(module_domain) as node:
        tf = Broadcaster(node)
        fixed = frames(JOINTS, {}, fixed=True) | {'imu_link': ('base_link', IMU)}
        tf.hold(**fixed)
        with start(
            'tracker', module_domain, *in_namespace('by_joints'), **common,
            joints__pan='pan', joints__tilt='tilt',
            imu__roll=float(roll), imu__pitch=float(pitch), imu__yaw=float(mounted_yaw),
        ), start(
            'tracker', module_domain, *in_namespace('by_tf'), **common,
            joints__use_tf='true', imu__use_tf='true',
        ):
            made = Boat(node, tf)
            node.spin_until(lambda: made.run(0.3) and all(made.tracks.values()))
            yield made


def test_by_tf_it_is_as_by_the_joints(boat: Boat) -> None:
    """The same tracks, with the gyro's mount by TF; predictions point to where the light is."""
    for each in (*boat.tracks.values(), boat.predictions, boat.diagnostics):
        each.clear()
    stamps = boat.run(1.5)
    both = [boat.tracked(name) for name in ('by_joints', 'by_tf')]
    # After the first ones, of which those by the joints know a rate past their newest sample.
    common = sorted(both[0].keys() & both[1].keys() & set(stamps[10:]))
    assert len(common) > 25
    apart = np.abs([both[0][each].state - both[1][each].state for each in common])
    # Angles of joints and quaternions are interpolated alike, to rounding. Where a busy machine
    # has the joints come late, they are extrapolated, and TF is waited for.
    assert np.median(apart[:, :2].max(axis=1)) < 1e-9
    assert apart[:, :2].max() < SIGMA
    # Their rates are over other intervals: 10 ms of 3 rad/s^2.
    assert apart[:, 2:].max() < 30.0
    late = [each for each in boat.predictions if to_ns(each.header.stamp) > stamps[15]]
    assert len(late) > 20
    errors = []
    for each in late:
        assert each.header.frame_id == BASE
        x, y, z = in_base(to_ns(each.header.stamp))
        errors.append([
            1e3 * atan2(x, z) - each.vector.x, 1e3 * atan2(-y, hypot(x, z)) - each.vector.y
        ])
    # Some 45 ms ahead by the gyro; by a mount that is 10 degrees off it would be a milliradian.
    assert np.sqrt(np.mean(np.square(errors))) < 0.15
    assert boat.values()['stabilised'] == 'yes'


def test_transforms_that_come_late_are_awaited(boat: Boat) -> None:
    """They are 35 ms behind the rays, and each ray but the first two becomes a track."""
    boat.tracks['by_tf'].clear()
    stamps = boat.run(0.8, tf_late_ms=60)
    boat.run(0.2)
    assert set(stamps[2:]) <= boat.tracked('by_tf').keys()


def test_transforms_that_do_not_come_are_named(boat: Boat) -> None:
    """Nothing is tracked meanwhile, by angles of long ago least of all."""
    boat.node.settle(0.2)
    boat.tracks['by_tf'].clear()
    boat.diagnostics.clear()
    boat.run(1.3, moves=False)
    boat.node.spin_until(lambda: boat.says(
        'the bearing has no direction in the base: the newest transform of',
    ))
    assert not boat.tracks['by_tf']
    boat.node.spin_until(lambda: boat.run(0.3) and boat.tracks['by_tf'])


def test_a_frame_that_never_comes_is_named(boat: Boat) -> None:
    """With what would connect it, for the camera and for the IMU."""
    assert boat.node.set_parameter('by_tf/tracker', 'joints.frame_id', 'mast').successful
    boat.tracks['by_tf'].clear()
    boat.diagnostics.clear()
    boat.node.spin_until(lambda: boat.run(0.3) and boat.says(
        "the bearing has no direction in the base: nothing was said of 'mast'; publish where "
        "'base_link' lies in 'mast'", "imu is not used: nothing was said of 'mast'",
        'known are base_link > base_optical_frame, imu_link, pan_link; camera_link >',
    ))
    assert not boat.tracks['by_tf']
    assert boat.node.set_parameter('by_tf/tracker', 'joints.frame_id', BASE).successful
    boat.node.spin_until(lambda: boat.run(0.3) and boat.tracks['by_tf'])


def test_where_both_are_there_the_joints_count_and_a_difference_is_told(boat: Boat) -> None:
    """TF has the tilt 30 mrad higher."""
    for name, value in (('joints.use_tf', True), ('imu.use_tf', True)):
        assert boat.node.set_parameter('by_joints/tracker', name, value).successful
    camera = frames(JOINTS, {}, fixed=True)['camera_link'][0]
    boat.tf.hold(camera_link=(camera, transform(0.03, 0.0, 0.02, pitch=-0.03)))
    boat.tf.hold(imu_link=('base_link', Transform(IMU.translation)))
    boat.tracks['by_joints'].clear()
    boat.diagnostics.clear()

    def told() -> bool:
        boat.run(0.3)
        words = ' '.join(
            status.message for array in boat.diagnostics for status in array.status
            if status.name.startswith('/by_joints')
        )
        return (
            f"joint_states has '{CAMERA}' in '{BASE}' 30.0 mrad from where TF has it" in words
            and f"imu.roll, imu.pitch, imu.yaw have '{BASE}' in 'imu_link' 1" in words
        )

    boat.node.spin_until(told)
    assert boat.tracks['by_joints']


def test_an_imu_that_rides_on_the_pan_is_refused(boat: Boat) -> None:
    """Its turning is that of the camera as well."""
    boat.diagnostics.clear()
    boat.tf.hold(imu_link=('pan_link', IMU))
    boat.node.spin_until(lambda: boat.run(0.3) and boat.says(
        "imu is not used: 'imu_link' has two parents, 'base_link' and 'pan_link'"
    ))

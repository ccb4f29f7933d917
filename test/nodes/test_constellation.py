"""Rays of a body's lights, as a locator publishes them -> poses, and a word for each fault."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, hypot
from pathlib import Path
import time
from typing import Any

from blob_tracker.flash_text import numbered_lights
from blob_tracker.ros.endpoints.qos import TF
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TwistWithCovarianceStamped
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from support.processes import Probe, probe, Process, start
from support.slowness import slowness
import yaml

Array = NDArray[np.float64]
SIGMA = 0.1  # mrad
LIGHTS = {
    'port': [0.2, 0.15, 0.0], 'starboard': [0.2, -0.15, 0.02], 'left': [-0.25, 0.1, 0.1],
    'right': [-0.2, -0.1, -0.05], 'mast': [0.0, 0.0, 0.2],
}
POSITION = np.array([0.5, -0.3, 2.0])
TURN = Rotation.from_euler('xyz', [2.0, 0.4, -0.7])
FRAME_ID = 'camera_optical_frame'
SIGHTINGS = 60
POSE = 0.3  # s for the pose of a sighting, where it has one: a queue holds ten of them


class Camera:
    """A camera that the test plays, before a running constellation."""

    def __init__(
        self, node: Probe, process: Process, topics: tuple[str, ...] = tuple(LIGHTS)
    ) -> None:
        self.node, self.process = node, process
        self.random = np.random.default_rng(7)
        self.poses = node.record(PoseWithCovarianceStamped, 'target/drone/pose')
        self.twists = node.record(TwistWithCovarianceStamped, 'target/drone/twist')
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        self._rays = {
            name: node.create_publisher(PoseWithCovarianceStamped, f'target/{topic}/ray', 100)
            for name, topic in zip(LIGHTS, topics, strict=True)
        }
        node.meet('constellation')
        node.spin_until(lambda: self.see() and self.poses and self.twists)

    def see(
        self, names: tuple[str, ...] = tuple(LIGHTS), twist: Array = np.zeros(6),
        frame_id: str = FRAME_ID, off: float = 0.0, step: float = 1e-3, ago: float = 0.0,
    ) -> int:
        """Publish rays `step` s apart, the first `off` by mrad; return the last stamp, ns."""
        last_ns = self.node.get_clock().now().nanoseconds - round(1e9 * ago)
        for index, name in enumerate(names):
            late = step * (index + 1 - len(names))  # s
            turn = Rotation.from_rotvec(late * twist[3:]) * TURN
            x, y, z = turn.apply(LIGHTS[name]) + POSITION + late * twist[:3]
            azimuth, elevation = atan2(x, z), atan2(-y, hypot(x, z))
            sigmas = SIGMA / np.array([np.cos(elevation), 1.0])
            noise = self.random.normal(0.0, sigmas)
            self._rays[name].publish(ray_message(
                Bearing(
                    1e3 * azimuth + noise[0] + (off if index == 0 else 0.0),
                    1e3 * elevation + noise[1], np.diag(sigmas**2), last_ns + round(1e9 * late),
                ),
                frame_id,
            ))
        self.node.spin(0.02)
        return last_ns

    def see_alone(self, twist: Array = np.zeros(6), ago: float = 0.0) -> int:
        """Publish rays, and wait for what comes of them, if anything does; return the stamp."""
        stamp_ns = self.see(twist=twist, ago=ago)
        until = time.monotonic() + POSE * slowness()
        while not self.placed(stamp_ns) and time.monotonic() < until:
            self.node.spin(0.005)
        return stamp_ns

    def placed(self, stamp_ns: int) -> bool:
        """Tell whether the last pose and twist are of a stamp."""
        return all(
            messages and to_ns(messages[-1].header.stamp) == stamp_ns
            for messages in (self.poses, self.twists)
        )

    def catch_up(self) -> None:
        """Wait until the node has taken all that was published."""
        self.node.spin_until(lambda: self.placed(self.see_alone()))

    def expect(self, sentence: str, level: bytes, plain: int = 0, **changed: Any) -> None:
        """Show sightings, each after some plain ones, until a diagnostic says this."""
        self.node.settle(0.2)
        self.diagnostics.clear()

        def said() -> bool:
            for _ in range(plain):
                self.see()
            self.see(**changed)
            return any(
                sentence in each.status[0].message and each.status[0].level == level
                for each in self.diagnostics
            )

        try:
            self.node.spin_until(said)
        except AssertionError:
            words = [each.status[0].message for each in self.diagnostics]
            raise AssertionError(f'{sentence!r} is not in {words}') from None
        assert self.process.running


@pytest.fixture(scope='module')
def camera(
    module_domain: int, tmp_path_factory: pytest.TempPathFactory, tf2_messages: None
) -> Iterator[Camera]:
    """Start the node once: surviving everything, one after the other, is the test."""
    path = tmp_path_factory.mktemp('body') / 'drone.yaml'
    path.write_text(yaml.safe_dump({'lights': LIGHTS}, sort_keys=False))
    with probe(module_domain) as node, start(
        'constellation', module_domain, body_url=f'file://{path}', body='drone',
        publish_tf='true',
    ) as process:
        yield Camera(node, process)


def test_tf_has_the_poses(camera: Camera) -> None:
    """The frame of the body in the optical one, at the stamp of the pose."""
    from tf2_msgs.msg import TFMessage

    transforms = camera.node.record(TFMessage, '/tf', TF)
    camera.node.spin_until(lambda: camera.see() and transforms)
    found, = transforms[-1].transforms
    camera.node.spin_until(lambda: any(
        to_ns(each.header.stamp) == to_ns(found.header.stamp) for each in camera.poses
    ))
    pose = next(each for each in camera.poses if each.header.stamp == found.header.stamp)
    assert (found.header.frame_id, found.child_frame_id) == (FRAME_ID, 'drone')
    place, turn = pose.pose.pose.position, pose.pose.pose.orientation
    assert found.transform.rotation == turn
    where = found.transform.translation
    assert (where.x, where.y, where.z) == (place.x, place.y, place.z)


def test_poses_and_twists_are_right_within_their_covariance(camera: Camera) -> None:
    """As ROS has it: position, and a turn about the fixed axes of the optical frame."""
    camera.catch_up()
    camera.poses.clear()
    camera.twists.clear()
    camera.random = np.random.default_rng(8)  # the same sightings, whatever was seen before
    twists = {}
    for number in range(SIGHTINGS):  # a second apart: each has a twist of its own
        twist = camera.random.normal(0.0, 3.0, 6)  # as speed_sigma and rate_sigma have it
        twists[camera.see_alone(twist, 1.0 * (SIGHTINGS - number))] = twist
    camera.node.spin_until(
        # One in twenty fits worse than its motion, which is not known yet, allows.
        lambda: min(len(camera.poses), len(camera.twists)) > 0.85 * SIGHTINGS)
    of_poses, of_twists = [], []
    for message in camera.poses:
        assert message.header.frame_id == FRAME_ID
        assert to_ns(message.header.stamp) in twists
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        found = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])
        error = np.concatenate([
            POSITION - [place.x, place.y, place.z], (TURN * found.inv()).as_rotvec(),
        ])
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        of_poses.append(error @ np.linalg.solve(covariance, error))
    for message in camera.twists:
        assert message.header.frame_id == FRAME_ID
        linear, angular = message.twist.twist.linear, message.twist.twist.angular
        error = twists[to_ns(message.header.stamp)] - [
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
        ]
        covariance = np.array(message.twist.covariance).reshape(6, 6)
        of_twists.append(error @ np.linalg.solve(covariance, error))
    for squared in (of_poses, of_twists):
        low, high = chi2.ppf([0.0005, 0.9995], 6 * len(squared))
        assert low < sum(squared) < high
    camera.expect('body placed', DiagnosticStatus.OK)
    values = {each.key: each.value for each in camera.diagnostics[-1].status[0].values}
    assert ' +- ' in values['x (m)']
    assert values['lights seen together'] == ', '.join(LIGHTS)


def test_a_light_that_is_not_the_bodys_is_named(camera: Camera) -> None:
    """The pose is that of the other four, also where the stamps are some ms apart."""
    camera.expect('body placed', DiagnosticStatus.OK)
    before = len(camera.poses)
    camera.expect(
        'the bearing of port is of another light', DiagnosticStatus.WARN, plain=3, off=20.0)
    assert len(camera.poses) > before


@pytest.mark.parametrize(('names', 'sentence'), [
    (('port', 'starboard', 'left'), ' poses of the body explain the bearings of port, starboard'),
    (('port', 'mast'), 'no pose: 2 lights are seen; a pose needs three or more'),
])
def test_no_pose_is_made_of_too_few_lights(
    camera: Camera, names: tuple[str, ...], sentence: str
) -> None:
    """Three lights have several, of which none is published; the reason is said."""
    camera.expect('body placed', DiagnosticStatus.OK)
    camera.node.settle(0.6)  # longer than a pose is followed, which three lights go on with
    before = len(camera.poses)
    camera.expect(sentence, DiagnosticStatus.WARN, names=names)
    assert len(camera.poses) == before


def test_rays_of_another_camera_are_refused(camera: Camera) -> None:
    """Each ray that is in another frame than the first is left out; the others count as before."""
    camera.catch_up()
    before = len(camera.poses)
    camera.expect(
        f"is in the frame 'other' and the first was in '{FRAME_ID}'", DiagnosticStatus.ERROR,
        frame_id='other',
    )
    assert len(camera.poses) == before
    camera.expect('body placed', DiagnosticStatus.OK)


def test_lights_without_names(domain: int, tmp_path: Path) -> None:
    """They are told by where they are; a body that is far away is doubted."""
    path = tmp_path / 'drone.yaml'
    path.write_text(yaml.safe_dump({'lights': LIGHTS}, sort_keys=False))
    topics = ('d', 'a', 'e', 'b', 'c')
    with probe(domain) as node, start(
        'constellation', domain, body_url=f'file://{path}', body='drone', unnamed='a,b,c,d,e',
        max_distance=1.0,
    ) as process:
        camera = Camera(node, process, topics)
        place = camera.poses[-1].pose.pose.position
        np.testing.assert_allclose([place.x, place.y, place.z], POSITION, atol=0.05)
        camera.expect(
            'by its file the body is 2 m away, further than max_distance', DiagnosticStatus.WARN)


@pytest.mark.parametrize('mode', ['steady', 'alternate'])
def test_a_body_of_lights_that_look_alike(domain: int, mode: str) -> None:
    """From frames to poses that are right: five lights, all steady or all in step."""
    names, url = ','.join(numbered_lights(5)), 'package://blob_tracker/config/drone.yaml'
    parameters = {'flash__mode': mode, 'flash__lights': 5, 'rate': 20.0, 'texture': 2.0}
    with probe(domain) as node, start(
        'pipeline', domain, source='simulator', body_url=url, **parameters
    ), start('constellation', domain, body_url=url, unnamed=names):
        true = node.record(PoseStamped, 'simulator/truth/pose')
        poses = node.record(PoseWithCovarianceStamped, 'target/body/pose')
        node.spin_until(lambda: len(poses) >= 12)
        node.settle(0.2)
    truths = {to_ns(each.header.stamp): each.pose for each in true}
    scaled = []
    for message in poses:
        truth, found = truths.get(to_ns(message.header.stamp)), message.pose.pose
        if truth is None:
            continue  # of a frame before the recording
        error = [getattr(truth.position, a) - getattr(found.position, a) for a in 'xyz']
        covariance = np.array(message.pose.covariance).reshape(6, 6)[:3, :3]
        scaled.append(np.array(error) @ np.linalg.solve(covariance, error))
    # The lights are off their places in the file by the same in each pose: not 3 n numbers.
    assert len(scaled) >= 6 and np.median(scaled) < chi2.ppf(0.999, 3)


@pytest.mark.parametrize(('lights', 'parameters', 'sentence'), [
    ({**LIGHTS, 'a/b': [0.0, 1.0, 0.0]}, {}, "'body_url': 'a/b' is not a name for a light"),
    (LIGHTS, {'unnamed': 'a,b/c'}, "'unnamed': 'b/c' is not a name for a light"),
    (LIGHTS, {'body_url': '/no/such.yaml'}, "'body_url': cannot read the body file /no/such"),
])
def test_what_cannot_be_is_said(
    tmp_path: Path, domain: int, lights: dict[str, list[float]], parameters: dict[str, object],
    sentence: str,
) -> None:
    """Exit code 2 with a sentence."""
    path = tmp_path / 'body.yaml'
    path.write_text(yaml.safe_dump({'lights': lights}))
    with start('constellation', domain, **{'body_url': path} | parameters) as process:
        assert process.wait() == 2
        assert sentence in process.output

"""`calibrate rig` from end to end: a bag of rays to parameters, and what is wrong with a bag."""

from __future__ import annotations

from pathlib import Path
import re

from blob_tracker.__main__ import main
from blob_tracker.nodes.interface.triangulator import ANGLES, AXES
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.simulation.waved_light import RigCamera
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped as Ray
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.bags_of_rays import recorded_rays
from support.processes import probe, start
from support.transforms import Broadcaster, transform
import yaml

CAMERAS = {
    'left': RigCamera((-1.0, 0.0, 0.0)), 'right': RigCamera((1.0, 0.0, 0.0), offset=0.012),
}
NODES = 'given', 'tf_alone'  # namespaces
LIGHT = np.array([4.0, -0.5, 0.3])


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', 'rig', *map(str, words)])


@pytest.fixture(scope='module')
def wand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the parameters of two cameras before which a wand was waved."""
    folder = tmp_path_factory.mktemp('wand')
    bag = recorded_rays(folder / 'bag', 0.5, ('red', 'blue'), CAMERAS)
    out = folder / 'rig.yaml'
    assert run(
        bag, '--cameras', 'left', '/right', '--wand', 'red', 'blue', 0.5, 0.0001, '--out', out
    ) == 0
    return out


def test_a_wand(wand: Path) -> None:
    """Poses, clocks and sigmas go into the file that the triangulator takes, and a picture."""
    text = wand.read_text()
    found = yaml.safe_load(text)['/**/triangulator']['ros__parameters']
    assert found['cameras'] == ['left', 'right']
    left, right = (
        {key: found[f'poses.{name}.{key}'] for key in ('x', 'y', 'z', 'yaw')}
        for name in ('left', 'right')
    )
    covariance = np.zeros((12, 12))
    covariance[np.tril_indices(12)] = found['pose_covariance']
    assert not covariance[:6].any()
    assert left['x'] == 0.0
    # The cameras look at a point 3 m ahead from 1 m aside each: 2 m apart, turned towards it.
    apart = np.hypot(right['x'], right['y'])
    sigma = np.sqrt(covariance.diagonal()[9:].max())
    assert 0.0 < sigma < 0.002
    assert abs(apart - 2.0) < 5.0 * sigma
    assert abs(right['z']) < 5.0 * sigma
    assert abs((right['yaw'] - left['yaw']) - 2.0 * np.arctan(1.0 / 3.0)) < 1e-3
    assert max(map(len, text.splitlines()[-10:])) <= 99
    assert 'right +12.0' in text or 'right +11.9' in text  # 16 us is its sigma
    assert '--child-frame-id right/optical' in text
    assert 'set frame_id to left/optical for left' in text
    assert wand.with_suffix('.png').read_bytes().startswith(b'\x89PNG')


def test_its_static_transforms_are_its_parameters(
    wand: Path, domain: int, tf2_messages: None
) -> None:
    """One triangulator takes the parameters, one TF: of the same rays they make one point."""
    text = wand.read_text()
    parameters = yaml.safe_load(text)['/**/triangulator']['ros__parameters']
    published = {}
    for line in re.findall('static_transform_publisher (.+)', text):
        words = dict(re.findall(r'--(\S+) (\S+)', line))
        parent, child = words.pop('frame-id'), words.pop('child-frame-id')
        published[child] = parent, transform(**{key: float(each) for key, each in words.items()})
    with (
        probe(domain) as node,
        start('triangulator', domain, '-r', '__ns:=/given', '--params-file', str(wand)),
        start('triangulator', domain, '-r', '__ns:=/tf_alone', use_tf='true'),
    ):
        Broadcaster(node).hold(**published)
        points = {
            name: node.record(PointStamped, f'{name}/target/point') for name in NODES
        }
        rays = {
            (name, camera): node.create_publisher(Ray, f'{name}/{camera}/target/ray', 10)
            for name in NODES for camera in CAMERAS
        }
        node.spin_until(lambda: all(each.get_subscription_count() for each in rays.values()))

        def see() -> int:
            stamp_ns = node.get_clock().now().nanoseconds
            for camera in CAMERAS:
                pose = {key: parameters[f'poses.{camera}.{key}'] for key in (*AXES, *ANGLES)}
                turn = Rotation.from_euler('xyz', [pose[key] for key in ANGLES])
                x, y, z = turn.inv().apply(LIGHT - [pose[key] for key in AXES])
                bearing = Bearing(
                    np.arctan2(x, z) / MRAD, np.arctan2(-y, np.hypot(x, z)) / MRAD,
                    0.01 * np.eye(2), stamp_ns,
                )
                for name in NODES:
                    rays[name, camera].publish(ray_message(bearing, f'{camera}/optical'))
            node.spin(0.05)
            return stamp_ns

        node.spin_until(lambda: see() and all(points.values()))
        stamp_ns = see()
        node.spin_until(lambda: all(
            to_ns(each[-1].header.stamp) == stamp_ns for each in points.values()
        ))
    for each in points.values():
        assert each[-1].header.frame_id == 'map'
        point = each[-1].point
        # What seven digits of the angles leave at 4 m.
        np.testing.assert_allclose([point.x, point.y, point.z], LIGHT, atol=1e-6)


def test_without_a_scale_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The picture is there, and the exit code tells."""
    bag = recorded_rays(tmp_path / 'bag', 0.0, ('',), CAMERAS)
    out = tmp_path / 'rig.yaml'
    assert run(bag, '--cameras', 'left', 'right', '--out', out) == 1
    assert not out.exists()
    assert out.with_suffix('.png').exists()
    assert 'give --wand or --baseline' in capsys.readouterr().err
    assert run(bag, '--cameras', 'left', 'top', '--out', out) == 1
    said = capsys.readouterr().err
    assert 'no rays on /top/target/ray' in said
    assert '/right/target/ray' in said


@pytest.mark.parametrize('words, sentence', [
    (('--wand', 'red', 'blue'), 'LIGHT LIGHT M'),
    (('--wand', 'red', 'blue', 'half'), 'LIGHT LIGHT M'),
    (('--baseline', 'left', 'right', 'nan'), 'CAMERA CAMERA M'),
    (('--wand', 'red', 'blue', '0.5', '--light', 'red'), 'named with it'),
    (('--most-offset', '-1'), '0 to 10 s'),
    (('--wand', 'red', 'red', '0.5'), 'a wand has two lights'),
    (('--frame-id', 'a"b'), 'the name of a frame'),
])
def test_options_that_are_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], sentence: str
) -> None:
    """They are refused before the bag is opened."""
    assert run(tmp_path / 'none', '--cameras', 'left', 'right', *words) == 2
    assert sentence in capsys.readouterr().err

"""`calibrate hand_eye` from end to end: a bag of rays and angles to parameters of the tracker."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from blob_tracker.__main__ import main
from blob_tracker.nodes.interface.tracker import PARAMETERS
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.simulation.panned_camera import PannedCamera
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import cv2
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from sensor_msgs.msg import JointState
from support.bags import START_NS, TYPES
import yaml

CAMERA = PannedCamera(
    np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -0.05]),
    np.array([0.0, 0.02, -0.05]), np.array([0.2, 0.1, 3.0]), clock=0.012,
)
RANGE = float(np.linalg.norm(CAMERA.light))


def recorded(
    folder: Path, joints: tuple[str, str] = ('head_pan', 'head_tilt'),
    camera: PannedCamera = CAMERA,
) -> Path:
    """Write a bag of it; return it."""
    rays, (ticks, turns) = camera.seen(np.random.default_rng(1), seconds=10.0)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        of_rays, of_joints = (
            writer.add_connection(topic, kind, typestore=TYPES) for topic, kind in (
                ('/target/ray', 'geometry_msgs/msg/PoseWithCovarianceStamped'),
                ('/joint_states', 'sensor_msgs/msg/JointState'),
            )
        )
        for time, (across, up), covariance in zip(*rays, strict=True):
            bearing = Bearing(
                across / MRAD, up / MRAD, covariance / MRAD**2, START_NS + round(1e9 * time))
            data = serialize_message(ray_message(bearing, 'optical'))
            writer.write(of_rays, bearing.stamp_ns, data)
        for time, (pan, tilt) in zip(ticks, turns, strict=True):
            message = JointState(name=list(joints), position=[pan, tilt])
            stamp_ns = START_NS + round(1e9 * time)
            message.header.stamp = from_ns(stamp_ns)
            writer.write(of_joints, stamp_ns, serialize_message(message))
    return folder


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', 'hand_eye', *map(str, words)])


def test_it_writes_what_the_tracker_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Joints, their signs and the offset of the clocks; the axes as comments."""
    out, bag = tmp_path / 'hand_eye.yaml', recorded(tmp_path / 'bag')
    joints = '--joints', 'head_pan', 'head_tilt'
    assert run(bag, *joints, '--distance', RANGE, '--out', out) == 0
    text = out.read_text()
    found = yaml.safe_load(text)['/**/tracker']['ros__parameters']
    assert found.keys() <= {each.name for each in PARAMETERS}
    assert (found['joints.pan'], found['joints.tilt']) == ('head_pan', 'head_tilt')
    assert found['joints.pan_reversed'] is True
    assert found['joints.tilt_reversed'] is False
    assert found['stamp_offset'] == pytest.approx(0.012, abs=5e-4)
    assert '<axis xyz="' in text
    assert 'pan arm z' in capsys.readouterr().out
    assert cv2.imread(str(tmp_path / 'hand_eye.png')).shape[1] >= 1000
    assert run(bag, '--out', out) == 1
    error = capsys.readouterr().err
    assert 'has no angle of the joint pan on joint_states' in error
    assert 'it has those of head_pan, head_tilt' in error


@pytest.mark.parametrize('joints', [('1', 'on'), ('a: b', 'y'), ('1e5', 'say "#"')])
def test_names_of_joints_stay_strings(tmp_path: Path, joints: tuple[str, str]) -> None:
    """Whatever YAML would take them for."""
    out = tmp_path / 'hand_eye.yaml'
    assert run(recorded(tmp_path / 'bag', joints), '--joints', *joints, '--out', out) == 0
    found = yaml.safe_load(out.read_text())['/**/tracker']['ros__parameters']
    assert (found['joints.pan'], found['joints.tilt']) == joints
    assert f'joints.pan: "{joints[0]}"' in out.read_text()


def test_the_tilt_of_an_axis_is_that_of_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A joint that counts the other way has the same: 20 mrad from y to x, -50 from x to z."""
    pan, tilt = (
        np.array(each) / np.linalg.norm(each) for each in ([0.02, 1.0, 0.0], [1.0, 0.0, -0.05]))
    joints = 'head_pan', 'head_tilt'
    for index, sign in enumerate((1.0, -1.0)):
        camera = replace(CAMERA, pan_axis=sign * pan, tilt_axis=sign * tilt)
        bag = recorded(tmp_path / f'bag{index}', joints, camera)
        assert run(bag, '--joints', *joints, '--out', tmp_path / 'hand_eye.yaml') == 0
        rows = [line.split('│') for line in capsys.readouterr().out.splitlines()]
        tilts = {
            row[1].strip(): float(row[2]) for row in rows if len(row) > 2 and 'axis,' in row[1]
        }
        assert tilts['pan axis, y to x'] == pytest.approx(20.0, abs=2.0)
        assert tilts['tilt axis, x to z'] == pytest.approx(-50.0, abs=2.0)


@pytest.mark.parametrize('words, sentence', [
    (('--distance', '1', '2', '3'), 'one number or two'),
    (('--joints', 'pan', 'pan'), '--joints are two'),
    (('--seconds', '0'), 'it must be 1 to 3600'),
])
def test_options_that_are_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], sentence: str
) -> None:
    """They are refused before the bag is opened."""
    assert run(tmp_path / 'none', *words) == 2
    assert sentence in capsys.readouterr().err

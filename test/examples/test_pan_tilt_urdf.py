"""The example's URDF: a tree whose angles are those that the tracker predicts."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.nodes.interface.camera import PARAMETERS as CAMERA
from blob_tracker.nodes.interface.optical_frame import PITCH, ROLL, YAW
from blob_tracker.nodes.interface.tracker import PARAMETERS as TRACKER
from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.tracking.rotation import pan_tilt
from blob_tracker.transforms import TransformTree
import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from support.urdf import frames, read_urdf

URDF = Path(__file__).parents[2] / 'examples' / 'pan_tilt.urdf'
LINKS, JOINTS = read_urdf(URDF)


def tree(**angles: float) -> TransformTree:
    """Return what robot_state_publisher says at these angles of the joints, rad."""
    made = TransformTree()
    for fixed in (True, False):
        for frame, (parent, how) in frames(JOINTS, angles, fixed=fixed).items():
            made.put_static(frame, parent, how)
    return made


def test_it_is_one_tree_of_its_links() -> None:
    """Each joint connects links that there are, and each but the root has one parent."""
    assert len(set(LINKS)) == len(LINKS)
    children = [joint.child for joint in JOINTS]
    assert sorted([*children, 'base_link']) == sorted(LINKS)
    assert {joint.parent for joint in JOINTS} <= set(LINKS)
    assert tree().frames == sorted(LINKS)
    assert len({joint.name for joint in JOINTS}) == len(JOINTS)


def test_the_names_are_those_of_the_parameters() -> None:
    """So that with their defaults nothing need be said."""
    defaults = {each.name: each.default for each in (*TRACKER, *CAMERA)}
    for name in ('joints.frame_id', 'imu.frame_id', 'frame_id'):
        assert defaults[name] in LINKS


@pytest.mark.parametrize('pan, tilt', [(0.0, 0.0), (0.4, 0.0), (0.0, 0.3), (-1.2, 0.6)])
def test_the_joints_are_the_angles_of_the_base(pan: float, tilt: float) -> None:
    """Pan to the right, tilt up: as the tracker turns the camera by joint_states."""
    found = tree(pan=pan, tilt=tilt).fixed('camera_optical_frame', 'base_optical_frame')
    np.testing.assert_allclose(found.matrix, pan_tilt(pan, tilt), atol=1e-9)


def test_optical_frames_are_those_of_rep_103() -> None:
    """The optical z axis points ahead, x right and y down; the default of imu.roll ... imu.yaw."""
    for optical, body in (
        ('camera_optical_frame', 'camera_link'), ('base_optical_frame', 'imu_link')
    ):
        turn = tree().fixed(optical, body).matrix
        np.testing.assert_allclose(
            turn, [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], atol=1e-9
        )
        np.testing.assert_allclose(turn, turn_of(ROLL, PITCH, YAW), atol=1e-9)


def test_ros_takes_it_from_a_command_line(domain: int) -> None:
    """As the value of a parameter it is read as YAML, which a colon or # in it would end."""
    context = Context()
    text = URDF.read_text()
    rclpy.init(
        args=['--ros-args', '-p', f'robot_description:={text}'], context=context,
        domain_id=domain,
    )
    node = Node('robot_state_publisher', context=context)
    try:
        value = node.declare_parameter('robot_description', '').value
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)
    # YAML folds the lines, and XML does not mind.
    assert value.split() == text.split()


def test_the_limits_are_those_of_the_servo_client() -> None:
    """Its parameter limit."""
    limits = {joint.name: joint.limits for joint in JOINTS if joint.kind != 'fixed'}
    assert limits == {'pan': (-1.5, 1.5), 'tilt': (-0.7, 0.7)}
    assert "'limit': ([1.5, 0.7], " in URDF.with_name(
        'servo_client.py'
    ).read_text()

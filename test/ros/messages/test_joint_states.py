"""The angles of joints, by their names."""

from math import isnan, nan

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.joint_states import to_angles
import pytest
from sensor_msgs.msg import JointState

MESSAGE = JointState(name=['wheel', 'pan', 'tilt'], position=[7.0, 0.3])


def test_angles_of_joints_by_their_names() -> None:
    """Of those that the message has; it may be of another part of the robot."""
    assert to_angles(MESSAGE, ('pan', 'head')) == {'pan': 0.3}
    assert to_angles(MESSAGE, ('head',)) == {}
    assert to_angles(JointState(), ('pan',)) == {}


def test_angle_that_is_not_known_yet() -> None:
    """It is told from a joint that the message does not have."""
    angles = to_angles(JointState(name=['pan', 'tilt'], position=[nan, 0.1]), ('pan', 'tilt'))
    assert isnan(angles['pan'])
    assert angles['tilt'] == 0.1


def test_joint_without_a_position_is_refused() -> None:
    """A message of velocities alone, say."""
    with pytest.raises(MessageError, match='3 names and 2 positions'):
        to_angles(MESSAGE, ('pan', 'tilt'))


def test_joint_that_stands_twice_is_refused() -> None:
    """Which of two positions is meant nobody knows; the same one twice is no matter."""
    twice = JointState(name=['pan', 'pan'], position=[0.3, 9.0])
    with pytest.raises(MessageError, match="'pan' stands twice"):
        to_angles(twice, ('pan',))
    twice.position[1] = 0.3
    assert to_angles(twice, ('pan',)) == {'pan': 0.3}

"""The angle of a joint, by its name."""

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.joint_states import to_angle
import pytest
from sensor_msgs.msg import JointState

MESSAGE = JointState(name=['wheel', 'pan', 'tilt'], position=[7.0, 0.3])


def test_angle_of_a_joint_by_its_name() -> None:
    """Reversed where it turns the other way, 0 where there is none, None of another part."""
    assert to_angle(MESSAGE, 'pan', False) == 0.3
    assert to_angle(MESSAGE, 'pan', True) == -0.3
    assert to_angle(MESSAGE, '', True) == 0.0
    assert to_angle(MESSAGE, 'head', False) is None


def test_joint_without_a_position_is_refused() -> None:
    """A message of velocities alone, say."""
    with pytest.raises(MessageError, match='3 names and 2 positions'):
        to_angle(MESSAGE, 'tilt', False)

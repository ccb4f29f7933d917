"""Names of lights are parts of topics."""

from __future__ import annotations

from blob_tracker.ros.endpoints.names import check_light, target_topic
from blob_tracker.ros.errors import ParameterError
import pytest
from rclpy.validate_topic_name import validate_topic_name


@pytest.mark.parametrize('name', ['a', 'port', 'Port_1', 'a' * 64])
def test_a_name_that_ros_takes(name: str) -> None:
    """The longest as well."""
    check_light(name)
    assert validate_topic_name(f'{target_topic(name)}/window/camera_info')


@pytest.mark.parametrize('name', ['', '1a', 'a__b', 'a_', 'a b', 'a/b', 'ä', 'a' * 65])
def test_a_name_that_ros_does_not_take_is_refused(name: str) -> None:
    """Or that would be too long."""
    with pytest.raises(ParameterError, match='is not a name for a light'):
        check_light(name)

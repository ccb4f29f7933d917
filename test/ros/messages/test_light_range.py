"""A range as ROS has it."""

from blob_tracker.camera.light_range import LightRange
from blob_tracker.ros.messages.light_range import range_message
from blob_tracker.ros.messages.stamp import to_ns
import pytest
from sensor_msgs.msg import Range


def test_a_range_with_its_variance() -> None:
    """Valid as REP 117 has it: between the least and the greatest."""
    message = range_message(LightRange(12.5, 0.04, 0.003), 1_700_000_000_123_456_789, 'optical')
    assert to_ns(message.header.stamp) == 1_700_000_000_123_456_789
    assert (message.header.frame_id, message.radiation_type) == ('optical', Range.INFRARED)
    assert message.min_range <= message.range <= message.max_range
    assert (message.range, message.variance, message.field_of_view) == pytest.approx(
        (12.5, 0.04, 0.003))

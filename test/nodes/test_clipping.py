"""A camera that clips below the saturation that is set is told of."""

from __future__ import annotations

from blob_tracker.nodes.segmenter import SegmenterNode
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.types import Frame
import numpy as np
import pytest
import rclpy
from sensor_msgs.msg import CameraInfo


@pytest.mark.parametrize('kind, saturation, told', [
    (np.uint16, 4095, True), (np.uint8, 235, True), (np.uint8, 255, False),
])
def test_a_camera_that_clips_below_is_told_of(
    kind: type, saturation: int, told: bool, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With what would be right; a camera of full scale gives no word."""
    said: list[str] = []
    monkeypatch.setattr(Health, 'fault', lambda self, level, message: said.append(message))
    rclpy.init(domain_id=domain)
    try:
        node = SegmenterNode(listen=False)
        frame = Frame(np.zeros((20, 30), kind), 1, saturation)
        node.segment(Delivery((frame, CameraInfo()), 'optical'))
        node.destroy_node()
    finally:
        rclpy.shutdown()
    sentence = f'the camera clips at {saturation} DN; set saturation to that'
    assert any(sentence in each for each in said) is told

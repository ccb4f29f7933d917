"""The examples in msg_examples/ are messages of the types that the nodes publish."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
import yaml

FOLDER = Path(__file__).parents[1] / 'msg_examples'
# Every topic that a node of the package publishes, by the name of its example.
TOPICS = {
    'camera_image_raw': 'sensor_msgs/msg/Image',
    'camera_camera_info': 'sensor_msgs/msg/CameraInfo',
    'target_window_image_raw': 'sensor_msgs/msg/Image',
    'target_window_camera_info': 'sensor_msgs/msg/CameraInfo',
    'target_visible': 'std_msgs/msg/Bool',
    'target_bearing': 'geometry_msgs/msg/Vector3Stamped',
    'target_centroid': 'geometry_msgs/msg/PointStamped',
    'target_noise': 'geometry_msgs/msg/Vector3Stamped',
    'target_ray': 'geometry_msgs/msg/PoseWithCovarianceStamped',
    'camera_debug_image': 'sensor_msgs/msg/Image',
    'segmenter_debug_image': 'sensor_msgs/msg/Image',
    'locator_debug_image': 'sensor_msgs/msg/Image',
    'simulator_debug_image': 'sensor_msgs/msg/Image',
    'simulator_truth_centroid': 'geometry_msgs/msg/PointStamped',
    'simulator_truth_bearing': 'geometry_msgs/msg/Vector3Stamped',
    'diagnostics': 'diagnostic_msgs/msg/DiagnosticArray',
    'clock': 'rosgraph_msgs/msg/Clock',
}


def fill(message: Any, content: dict[str, Any]) -> None:
    """Set every field of a message, nested ones too; a field that is unknown or left out fails."""
    fields = message.get_fields_and_field_types()
    assert set(content) == set(fields)
    for name, value in content.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            package, kind = fields[name].removeprefix('sequence<').rstrip('>').split('/')
            elements = []
            for item in value:
                elements.append(getattr(import_module(f'{package}.msg'), kind)())
                fill(elements[-1], item)
            setattr(message, name, elements)
        elif fields[name] == 'octet':
            setattr(message, name, bytes([value]))
        else:
            setattr(message, name, value)


def test_every_topic_has_an_example() -> None:
    """No more and no fewer."""
    assert {path.stem for path in FOLDER.glob('*.yaml')} == set(TOPICS)


@pytest.mark.parametrize('name', TOPICS)
def test_example_is_a_message_of_its_type(name: str) -> None:
    """Each field exists, has the right type, and none is missing."""
    package, _, kind = TOPICS[name].split('/')
    text = (FOLDER / f'{name}.yaml').read_text()
    assert text.startswith(f'# {TOPICS[name]} on ')
    message = getattr(import_module(f'{package}.msg'), kind)()
    fill(message, yaml.safe_load(text))
    if kind == 'Image':
        assert len(message.data) == message.step * message.height

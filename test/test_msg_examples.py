"""The examples in msg_examples/ are messages of the types that the nodes publish."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from blob_tracker.nodes import NODES
from blob_tracker.nodes.interface import interface_of
from blob_tracker.ros.messages.image import to_window
import pytest
import yaml

FOLDER = Path(__file__).parents[1] / 'msg_examples'
# Type of every topic that a node, or the replay of a bag, publishes, by the name of its example.
TOPICS = {
    interface.resolved(topic.name).lstrip('/').replace('/', '_'): topic.kind.replace('/', '/msg/')
    for interface in map(interface_of, NODES)
    for topic in interface.published
} | {'clock': 'rosgraph_msgs/msg/Clock'}
# Of a coded light, whose name is in theirs.
TOPICS |= {
    name.replace('target', 'target_port'): TOPICS[name]
    for name in (
        'target_window_image_raw', 'target_window_camera_info', 'target_bearing',
        'target_centroid', 'target_ray', 'target_track', 'target_bearing_predicted',
    )
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


@pytest.mark.usefixtures('tf2_messages')
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


def test_the_window_of_a_coded_light_tells_how_it_was_seen() -> None:
    """Share and way of the glimpse, and the place of the window, are read back."""
    found = []
    for end in ('image_raw', 'camera_info'):
        name = f'target_port_window_{end}'
        package, _, kind = TOPICS[name].split('/')
        found.append(getattr(import_module(f'{package}.msg'), kind)())
        fill(found[-1], yaml.safe_load((FOLDER / f'{name}.yaml').read_text()))
    image, info = found
    assert image.header == info.header
    info.roi.width, info.roi.height = image.width, image.height  # it is cut
    glimpse = to_window(image, info).glimpse
    assert glimpse is not None
    assert 0.0 < glimpse.share < 1.0

"""The examples in msg_examples/ are messages of the types that the nodes publish."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from blob_tracker import CameraModel, Frame, Pipeline, SensorNoise
from blob_tracker.commands.echo import in_words
from blob_tracker.nodes import NODES
from blob_tracker.nodes.interface import interface_of
from blob_tracker.ros.messages.image import to_window
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.simulation import flashing_light
import numpy as np
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


def example(name: str) -> Any:
    """Return an example as a message of its type."""
    package, _, kind = TOPICS[name].split('/')
    message = getattr(import_module(f'{package}.msg'), kind)()
    fill(message, yaml.safe_load((FOLDER / f'{name}.yaml').read_text()))
    return message


def test_every_topic_has_an_example() -> None:
    """No more and no fewer."""
    assert {path.stem for path in FOLDER.glob('*.yaml')} == set(TOPICS)


@pytest.mark.usefixtures('tf2_messages')
@pytest.mark.parametrize('name', TOPICS)
def test_example_is_a_message_of_its_type(name: str) -> None:
    """Each field exists, has the right type, and none is missing."""
    assert (FOLDER / f'{name}.yaml').read_text().startswith(f'# {TOPICS[name]} on ')
    message = example(name)
    if TOPICS[name].endswith('/Image'):
        assert len(message.data) == message.step * message.height


def test_the_window_of_a_coded_light_tells_how_it_was_seen() -> None:
    """Share and way of the glimpse, and the place of the window, are read back."""
    image, info = (example(f'target_port_window_{end}') for end in ('image_raw', 'camera_info'))
    assert image.header == info.header
    info.roi.width, info.roi.height = image.width, image.height  # it is cut
    glimpse = to_window(image, info).glimpse
    assert glimpse is not None
    assert 0.0 < glimpse.share < 1.0


def test_the_target_is_that_of_the_simulator() -> None:
    """In its frame 28, by the chain as it is now; to far less than a sigma on any processor."""
    info, scene = example('camera_camera_info'), flashing_light()
    pipeline = Pipeline(
        CameraModel(info.width, info.height, info.k.reshape(3, 3)), noise=SensorNoise(40.0, 0.7)
    )
    frames = (Frame(scene.frame(index), scene.stamp_ns(index), 255) for index in range(29))
    _, location, bearing = [found for frame in frames for found in pipeline.placed(frame)][-1]
    told = to_bearing(example('target_ray'))
    angles, centroid = example('target_bearing').vector, example('target_centroid').point
    assert (angles.x, angles.y) == pytest.approx((told.azimuth, told.elevation), rel=1e-12)
    assert (angles.x, angles.y) == pytest.approx((bearing.azimuth, bearing.elevation), abs=1e-3)
    assert (centroid.x, centroid.y) == pytest.approx((location.x, location.y), abs=1e-3)
    np.testing.assert_allclose(told.covariance, bearing.covariance, rtol=1e-2, atol=1e-6)


def test_the_first_page_shows_the_examples() -> None:
    """What `ros2 topic echo` and `echo` print of them, and what the diagnostics say."""
    page = (FOLDER.parent / 'docs' / 'start_with_ros.md').read_text()
    ray, angles = example('target_ray'), example('target_bearing').vector
    assert f'{in_words(to_bearing(ray))}, in {ray.header.frame_id}\n' in page
    assert f'x: {angles.x:.3f}`' in page
    assert f'y: {angles.y:.3f}`' in page
    said = {each.key: each.value for each in example('diagnostics').status[0].values}
    sigmas = to_bearing(ray).covariance.diagonal() ** 0.5
    assert [said[f'sigma {angle} (mrad)'] for angle in ('azimuth', 'elevation')] == [
        f'{sigma:.4f}' for sigma in sigmas
    ]

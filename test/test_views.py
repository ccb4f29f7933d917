"""The views for RViz and Foxglove show what the nodes publish, as it is published."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
import json
import re
from typing import Any

from blob_tracker.resources import config_path
import pytest
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    qos_check_compatible,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
)
from support.processes import Probe, probe, start
import yaml

RVIZ = yaml.safe_load(config_path('blob_tracker.rviz').read_text())
FOXGLOVE = json.loads(config_path('foxglove_layout.json').read_text())
# Of rviz_default_plugins/plugins_description.xml in Jazzy: the displays that have a topic, with
# its type, and all the others that the file may use.
DISPLAYS = {
    'rviz_default_plugins/Image': 'sensor_msgs/msg/Image',
    'rviz_default_plugins/PoseWithCovariance': 'geometry_msgs/msg/PoseWithCovarianceStamped',
    'rviz_default_plugins/PointStamped': 'geometry_msgs/msg/PointStamped',
}
OTHERS = {
    'rviz_default_plugins/Grid',
    'rviz_default_plugins/Interact',
    'rviz_default_plugins/MoveCamera',
    'rviz_default_plugins/Select',
    'rviz_default_plugins/FocusCamera',
    'rviz_default_plugins/Measure',
    'rviz_default_plugins/Orbit',
    'rviz_default_plugins/TF',
    'rviz_common/Displays',
    'rviz_common/Views',
    'rviz_common/Time',
}
PANELS = {'3D', 'DiagnosticSummary', 'Image', 'Indicator', 'Parameters', 'Plot'}


@pytest.fixture(scope='module')
def running(module_domain: int) -> Iterator[Probe]:
    """Run the whole tracker in one process, and look at it."""
    with (
        probe(module_domain) as node,
        start('pipeline', module_domain, source='simulator'),
    ):
        node.spin_until(lambda: node.get_publishers_info_by_topic('/target/ray'), timeout=60.0)
        node.settle(0.5)
        yield node


def nested(content: Any) -> Iterator[dict[str, Any]]:
    """Yield every mapping of a YAML or JSON document."""
    if isinstance(content, dict):
        yield content
        content = list(content.values())
    if isinstance(content, list):
        for item in content:
            yield from nested(item)


def rviz_displays() -> list[dict[str, Any]]:
    """Return the displays that have a topic."""
    return [d for d in RVIZ['Visualization Manager']['Displays'] if 'Topic' in d]


def rviz_qos(topic: dict[str, Any]) -> QoSProfile:
    """Return the QoS in RViz' words as a profile."""
    return QoSProfile(
        depth=topic['Depth'],
        liveliness=LivelinessPolicy.AUTOMATIC,
        history={'Keep Last': HistoryPolicy.KEEP_LAST}[topic['History Policy']],
        reliability={
            'Reliable': ReliabilityPolicy.RELIABLE, 'Best Effort': ReliabilityPolicy.BEST_EFFORT,
        }[topic['Reliability Policy']],
        durability={
            'Volatile': DurabilityPolicy.VOLATILE,
            'Transient Local': DurabilityPolicy.TRANSIENT_LOCAL,
        }[topic['Durability Policy']],
    )


def foxglove_topics() -> dict[str, set[str]]:
    """Return each topic of the layout with the types that its panels take."""
    topics: dict[str, set[str]] = {}
    for name, panel in FOXGLOVE['configById'].items():
        kind = name.split('!')[0]
        if kind == 'DiagnosticSummary':
            topics.setdefault(panel['topicToRender'], set()).add(
                'diagnostic_msgs/msg/DiagnosticArray'
            )
        for topic in panel.get('topics', ()):
            topics.setdefault(topic, set()).add('geometry_msgs/msg/PoseWithCovarianceStamped')
        for key, message in (('imageTopic', 'Image'), ('calibrationTopic', 'CameraInfo')):
            if key in panel.get('imageMode', ()):
                topics.setdefault(panel['imageMode'][key], set()).add(f'sensor_msgs/msg/{message}')
    return topics


def foxglove_paths() -> list[str]:
    """Return the message paths of plots and indicators."""
    return [
        path for panel in FOXGLOVE['configById'].values()
        for path in [*(p['value'] for p in panel.get('paths', ())), panel.get('path')] if path
    ]


def published(node: Probe, topic: str) -> tuple[str, QoSProfile]:
    """Return type and QoS of the publisher of a topic."""
    infos = node.get_publishers_info_by_topic(topic)
    assert infos, f'nobody publishes {topic}'
    return infos[0].topic_type, infos[0].qos_profile


def test_rviz_file_names_what_rviz_has() -> None:
    """Its classes are those of RViz, and the ray's frame is the one that all is drawn in."""
    classes = {mapping['Class'] for mapping in nested(RVIZ) if mapping.get('Class')}
    assert classes <= OTHERS | set(DISPLAYS)
    shown = [display['Topic']['Value'] for display in rviz_displays()]
    assert shown == [
        'target/ray', 'camera/image_raw', 'segmenter/debug_image', 'locator/debug_image'
    ]
    manager = RVIZ['Visualization Manager']
    assert manager['Global Options']['Fixed Frame'] == 'camera_optical_frame'
    ray = rviz_displays()[0]
    assert ray['Covariance']['Value'] and ray['Covariance']['Orientation']['Value']
    assert ray['Shape'] == 'Axes'  # an arrow would lie along x, and z is the ray


@pytest.mark.parametrize('display', rviz_displays(), ids=lambda d: d['Name'])
def test_rviz_display_hears_its_topic(display: dict[str, Any], running: Probe) -> None:
    """It has the type of the display, and a QoS that matches."""
    kind, qos = published(running, '/' + display['Topic']['Value'])
    assert kind == DISPLAYS[display['Class']]
    compatibility, reason = qos_check_compatible(qos, rviz_qos(display['Topic']))
    assert compatibility == QoSCompatibility.OK, reason


def test_foxglove_layout_shows_each_of_its_panels() -> None:
    """Every panel is of a known type, has a place, and every place has a panel."""
    places = re.findall(r'"(?:first|second)": "([^"]+)"', json.dumps(FOXGLOVE['layout']))
    assert sorted(places) == sorted(FOXGLOVE['configById'])
    assert {name.split('!')[0] for name in places} == PANELS


def test_foxglove_topics_are_published_with_their_types(running: Probe) -> None:
    """The bridge takes the QoS of the publisher; only names and types can be wrong."""
    topics = foxglove_topics()
    assert '/target/ray' in topics
    for topic, kinds in topics.items():
        assert kinds == {published(running, topic)[0]}


@pytest.mark.parametrize('path', foxglove_paths())
def test_foxglove_path_leads_to_a_number(path: str, running: Probe) -> None:
    """A path is topic, fields, an index, and at most one function."""
    match = re.fullmatch(r'(/[a-z_/]+)\.([a-z_.]+?)(?:\[(\d+)\])?(?:\.@(sqrt))?', path)
    assert match, path
    topic, fields, index, _ = match.groups()
    package, _, kind = published(running, topic)[0].split('/')
    value = getattr(import_module(f'{package}.msg'), kind)()
    for name in fields.split('.'):
        value = getattr(value, name)
    if index is not None:
        value = value[int(index)]
    assert isinstance(value, (bool, float))

"""The running nodes have the topics, services and parameters that are declared, and no others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from blob_tracker.nodes.interface import interface_of
from blob_tracker.resources import config_path
from blob_tracker.ros.interface import Interface, Service, Topic
import pytest
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from support.node_classes import CHANGED, CLASSES, OPENED
import yaml

# Of the topics that parameters open.
pytestmark = pytest.mark.usefixtures('tf2_messages')

# What rclpy gives to every node.
TOPICS = {'/rosout', '/parameter_events'}
SERVICES = (
    'describe_parameters', 'get_parameter_types', 'get_parameters', 'get_type_description',
    'list_parameters', 'set_parameters', 'set_parameters_atomically',
)
PARAMETERS = {'use_sim_time', 'start_type_description_service'}
ARGUMENTS = ('camera:device:=/dev/no_such_device', *(
    f'{node}:{name}:={str(value).lower()}'
    for node, values in OPENED.items()
    for name, value in values.items()
))

Ends = dict[str, str]  # type by name


@pytest.fixture
def nodes(domain: int) -> Iterator[dict[str, Node]]:
    """Give one of each node, by name."""
    rclpy.init(
        args=['--ros-args', *(word for each in ARGUMENTS for word in ('-p', each))],
        domain_id=domain,
    )
    made: list[Node] = []
    try:
        for kind in CLASSES.values():
            made.append(kind())
            made[-1].set_parameters([
                Parameter(name, value=value)
                for name, value in CHANGED.get(made[-1].get_name(), {}).items()
            ])
        yield {node.get_name(): node for node in made}
    finally:
        for node in made:
            node.destroy_node()
        rclpy.try_shutdown()


def published(node: Node) -> Ends:
    """Return what the graph says that a node publishes."""
    return _ends(node.get_publisher_names_and_types_by_node(node.get_name(), '/'))


def subscribed(node: Node) -> Ends:
    """Return what the graph says that a node subscribes to."""
    return _ends(node.get_subscriber_names_and_types_by_node(node.get_name(), '/'))


def services(node: Node) -> Ends:
    """Return what the graph says that a node offers."""
    name = node.get_name()
    common = {f'/{name}/{service}' for service in SERVICES}
    offered = _ends(node.get_service_names_and_types_by_node(name, '/'))
    return {service: kind for service, kind in offered.items() if service not in common}


def _ends(names_and_types: list[tuple[str, list[str]]]) -> Ends:
    found = {}
    for name, types in names_and_types:
        if name not in TOPICS:
            package, _, kind = types[0].split('/')
            assert len(types) == 1
            found[name] = f'{package}/{kind}'
    return found


def declared(interface: Interface, ends: Sequence[Topic] | Sequence[Service]) -> Ends:
    """Return what an interface says, with the names that the graph has."""
    return {'/' + interface.resolved(each.name).lstrip('/'): each.kind for each in ends}


def test_the_graph_is_what_is_declared(nodes: dict[str, Node]) -> None:
    """Names and types, both ways: nothing is missing and nothing is there besides."""
    for name, node in nodes.items():
        interface = interface_of(name)
        assert published(node) == declared(interface, interface.published)
        assert subscribed(node) == declared(interface, interface.subscribed)
        assert services(node) == declared(interface, interface.services)


def test_each_parameter_is_declared_and_each_topic_has_its_qos(nodes: dict[str, Node]) -> None:
    """What config/replay.yaml overrides is there to be overridden."""
    overrides = yaml.safe_load(config_path('replay.yaml').read_text())
    for name, node in nodes.items():
        interface = interface_of(name)
        given = set(node.get_parameters_by_prefix('')) - PARAMETERS
        qos = {each for each in given if each.startswith('qos_overrides.')}
        assert given - qos == {each.name for each in interface.parameters}
        ends = {each.rsplit('.', 1)[0] for each in qos}
        assert ends == {
            f'qos_overrides.{topic}.{end}'
            for end, topics in (
                ('publisher', interface.published), ('subscription', interface.subscribed)
            )
            for topic in declared(interface, topics)
        }
        for key, policies in overrides.pop(f'/**/{name}', {}).get('ros__parameters', {}).items():
            assert {f'{key}.{policy}' for policy in policies} <= qos
    assert not overrides, 'nodes that there are not'


def test_each_coded_light_has_these_topics_under_its_name(nodes: dict[str, Node]) -> None:
    """The topics of a light that is taken away stay, silent: `process.run` says why."""
    before = {
        name: {each for each in topics(nodes[name]) if each.startswith('/target/')}
        for name, topics in (
            ('segmenter', published), ('locator', published), ('tracker', published)
        )
    }
    segmenter, locator, tracker = (nodes[name] for name in ('segmenter', 'locator', 'tracker'))
    listened_before = {node: set(subscribed(node)) for node in (locator, tracker)}
    assert segmenter.set_parameters_atomically([
        Parameter('flash.mode', value='coded'),
        Parameter('flash.codes', value='port:1101000,starboard:1110100'),
    ]).successful
    for node in (locator, tracker):
        assert node.set_parameters([Parameter('lights', value='port')])[0].successful
    named = {name for name in published(segmenter) if name.startswith('/target/')}
    ends = 'window/image_raw', 'window/camera_info', 'visible'
    lights = {f'/target/{light}/{end}' for light in ('port', 'starboard') for end in ends}
    assert named == lights | before['segmenter']
    named = {name for name in published(locator) if name.startswith('/target/')}
    of_locator = 'bearing', 'centroid', 'range', 'ray'
    assert named == {f'/target/port/{end}' for end in of_locator} | before['locator']
    listened = {f'/target/port/window/{end}' for end in ('image_raw', 'camera_info')}
    assert set(subscribed(locator)) == listened | listened_before[locator]
    named = {name for name in published(tracker) if name.startswith('/target/')}
    ends = 'bearing_predicted', 'track', 'tracked'
    assert named == {f'/target/port/{end}' for end in ends} | before['tracker']
    assert set(subscribed(tracker)) == {'/target/port/ray'} | listened_before[tracker]

"""The SROS2 policy allows what the running nodes have, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from fnmatch import fnmatchcase
from xml.etree import ElementTree

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.nodes.locator import LocatorNode
from blob_tracker.resources import config_path
from blob_tracker.ros.camera_info import from_camera_model
from blob_tracker.types import Window
import numpy as np
from processes import Probe, probe, start
import pytest
import rclpy

POLICY = config_path('security/policy.xml')
# The schema of SROS2 (sros2/policy/schemas/policy.xsd, version 0.2.0): the children that an
# element may have, and the attributes that it must or may have.
CHILDREN = {
    'policy': {'enclaves'},
    'enclaves': {'enclave'},
    'enclave': {'profiles'},
    'profiles': {'profile'},
    'profile': {'topics', 'services'},
    'topics': {'topic'},
    'services': {'service'},
    'topic': set(),
    'service': set(),
}
ATTRIBUTES = {
    'policy': ({'version'}, set()),
    'enclave': ({'path'}, set()),
    'profile': ({'ns', 'node'}, set()),
    'topics': (set(), {'publish', 'subscribe'}),
    'services': (set(), {'reply', 'request'}),
}
# What a rule of the policy is in the graph: the probe's question for it.
QUESTIONS = {
    'publish': 'get_publisher_names_and_types_by_node',
    'subscribe': 'get_subscriber_names_and_types_by_node',
    'reply': 'get_service_names_and_types_by_node',
    'request': 'get_client_names_and_types_by_node',
}
CODED = {'flash.mode': 'coded', 'flash.codes': 'port:1101000,starboard:1110100'}
# What opens each topic that is not always there: enclave -> the ways to start its process.
STARTS: dict[str, tuple[dict[str, object], ...]] = {
    'camera': ({'device': '/dev/no_such_camera'},),
    'segmenter': ({}, CODED),
    'locator': ({'noise.online': True}, {'lights': 'port,starboard'}),
    'simulator': ({},),
    'pipeline': (
        {'device': '/dev/no_such_camera', 'noise.online': True},
        {'device': '/dev/no_such_camera', **CODED},
    ),
    'pipeline_images': (
        {'source': 'images', 'noise.online': True},
        {'source': 'images', **CODED},
    ),
}
Rights = dict[str, set[str]]  # kind of rule -> names


def enclaves() -> Iterator[tuple[str, ElementTree.Element]]:
    """Return each enclave with its name, less the part that all have."""
    for enclave in ElementTree.parse(POLICY).iter('enclave'):
        yield enclave.attrib['path'].removeprefix('/blob_tracker/'), enclave


def full_name(name: str, namespace: str, node: str) -> str:
    """Return the name of a topic as SROS2 resolves it (templates/dds/permissions.xsl)."""
    if name.startswith('/'):
        return name
    if name.startswith('~'):
        return f'{namespace}/{node}{name[1:]}'
    return f'{namespace}/{name}'


def allowed(profile: ElementTree.Element, namespace: str) -> Rights:
    """Return what a profile allows in a namespace."""
    rights: Rights = {kind: set() for kind in QUESTIONS}
    for rule in profile:
        for kind in rule.attrib:
            rights[kind] |= {
                full_name(str(each.text), namespace, profile.attrib['node']) for each in rule
            }
    return rights


def existing(observer: Probe, node: str, namespace: str) -> Rights:
    """Return what a running node has."""
    return {
        kind: {name for name, _ in getattr(observer, question)(node, namespace)}
        for kind, question in QUESTIONS.items()
    }


def located(namespace: str) -> set[str]:
    """Return what a locator within the pipeline publishes on from its first windows on."""
    node = LocatorNode(listen=False)
    try:
        model = CameraModel(64, 64, pinhole_matrix(100.0, 64, 64))
        lit = np.full((9, 9), 10, np.uint8)
        lit[3:6, 3:6] = 100
        window = Window(lit=lit, unlit=np.full_like(lit, 10), x0=20, y0=20, saturation=255)
        for light in ('', 'port'):
            node.locate(light, window, from_camera_model(model, 64, 64), 'camera_optical_frame')
        names = {publisher.topic_name for publisher in node.publishers}
        return {f'{namespace}{name}' for name in names if name.startswith('/target/')}
    finally:
        node.destroy_node()


def test_the_policy_has_the_form_of_sros2() -> None:
    """Each element is where it may be and has the attributes it must have, each rule a value."""
    # sros2 takes whatever stands directly in <enclaves>, a comment too, for an enclave.
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.parse(POLICY, parser).getroot()
    assert root.tag == 'policy'
    assert root.attrib['version'] == '0.2.0'
    assert all(isinstance(child.tag, str) for child in root.find('enclaves'))
    for element in root.iter():
        if not isinstance(element.tag, str):
            continue
        children = [child.tag for child in element if isinstance(child.tag, str)]
        assert set(children) <= CHILDREN[element.tag], element.tag
        assert bool(children) != (element.tag in ('topic', 'service')), element.tag
        must, may = ATTRIBUTES.get(element.tag, (set(), set()))
        assert must <= set(element.attrib) <= must | may, element.attrib
        if may:
            assert set(element.attrib.values()) == {'ALLOW'}
        if not children:
            assert element.text == element.text.strip() != ''


def test_a_process_has_one_enclave() -> None:
    """No enclave twice, and none of which this file does not know how to start the process."""
    assert sorted(name for name, _ in enclaves()) == sorted(STARTS)


def settled(observer: Probe, nodes: set[tuple[str, str]]) -> dict[tuple[str, str], Rights]:
    """Return what nodes have once all are whole: the graph has been the same for a second."""
    last: list[dict[tuple[str, str], Rights]] = []

    def steady() -> bool:
        if not nodes <= set(observer.get_node_names_and_namespaces()):
            return False
        last.append({each: existing(observer, *each) for each in nodes})
        if last[-2:-1] == last[-1:]:
            return True
        observer.spin(1.0)
        return False

    observer.spin_until(steady, timeout=90.0)
    return last[-1]


@pytest.mark.timeout(180)  # ten processes start at once
def test_each_node_has_what_the_policy_allows_and_nothing_else(domain: int) -> None:
    """Topics, services and clients of every node, with all that is conditional opened."""
    profiles = [(enclave, profile) for enclave, element in enclaves()
                for profile in element.iter('profile')]
    with probe(domain) as observer, ExitStack() as stack:
        for enclave, ways in STARTS.items():
            for number, parameters in enumerate(ways):
                arguments = ['-r', f'__ns:=/{enclave}_{number}', '-p', 'use_sim_time:=true']
                for name, value in parameters.items():
                    arguments += ['-p', f'{name}:={value}']
                program = 'pipeline' if enclave.startswith('pipeline') else enclave
                stack.enter_context(start(program, domain, *arguments))
        graph = settled(observer, {
            (profile.attrib['node'], f'/{enclave}_{number}')
            for enclave, profile in profiles for number in range(len(STARTS[enclave]))
        })
    rclpy.init(domain_id=domain)
    try:
        for (node, namespace), rights in graph.items():
            if node == 'locator' and namespace.startswith('/pipeline'):
                rights['publish'] |= located(namespace)
    finally:
        rclpy.shutdown()
    missing, superfluous = set(), set()
    for enclave, profile in profiles:
        used = set()
        for number in range(len(STARTS[enclave])):
            node, namespace = profile.attrib['node'], f'/{enclave}_{number}'
            for kind, expressions in allowed(profile, namespace).items():
                for name in graph[node, namespace][kind]:
                    fitting = {e for e in expressions if fnmatchcase(name, e)}
                    used |= {(kind, e.removeprefix(namespace)) for e in fitting}
                    if not fitting:
                        missing.add(f'{enclave}: {node} {kind} {name}')
        for kind, expressions in allowed(profile, '').items():
            superfluous |= {
                f'{enclave}: {node} {kind} {e}' for e in expressions if (kind, e) not in used
            }
    assert not missing, 'not allowed, and done: ' + '; '.join(sorted(missing))
    assert not superfluous, 'allowed, and never done: ' + '; '.join(sorted(superfluous))

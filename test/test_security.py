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


def located_topics(domain: int, observer: Probe, namespace: str, light: str) -> Rights:
    """Return what a locator has that was handed the window of a light in memory."""
    rclpy.init(args=['--ros-args', '-r', f'__ns:={namespace}'], domain_id=domain)
    node = LocatorNode(listen=False)
    try:
        model = CameraModel(64, 64, pinhole_matrix(100.0, 64, 64))
        lit = np.full((9, 9), 10, np.uint8)
        lit[3:6, 3:6] = 100
        window = Window(lit=lit, unlit=np.full_like(lit, 10), x0=20, y0=20, saturation=255)
        node.locate(light, window, from_camera_model(model, 64, 64), 'camera_optical_frame')
        # All three are made at once, so when one is seen the graph has them all.
        bearing = f'{namespace}/target/{light}/bearing'.replace('//', '/')
        observer.spin_until(
            lambda: ('locator', namespace) in observer.get_node_names_and_namespaces()
            and bearing in existing(observer, 'locator', namespace)['publish']
        )
        return existing(observer, 'locator', namespace)
    finally:
        node.destroy_node()
        rclpy.shutdown()


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


@pytest.mark.timeout(180)  # eleven processes start at once
def test_each_node_has_what_the_policy_allows_and_nothing_else(domain: int) -> None:
    """Topics, services and clients of every node, with all that is conditional opened."""
    missing, superfluous = [], []
    with probe(domain) as observer, ExitStack() as stack:
        for enclave, ways in STARTS.items():
            for number, parameters in enumerate(ways):
                arguments = ['-r', f'__ns:=/{enclave}_{number}', '-p', 'use_sim_time:=true']
                for name, value in parameters.items():
                    arguments += ['-p', f'{name}:={value}']
                program = 'pipeline' if enclave.startswith('pipeline') else enclave
                stack.enter_context(start(program, domain, *arguments))
        for enclave, element in enclaves():
            for profile in element.iter('profile'):
                node = profile.attrib['node']
                unused: Rights | None = None
                for number in range(len(STARTS[enclave])):
                    namespace = f'/{enclave}_{number}'
                    rights = allowed(profile, namespace)
                    has = settled(observer, node, namespace)
                    if enclave.startswith('pipeline') and node == 'locator':
                        # In memory a locator has a light's topics from its first window on.
                        light = ['', 'port'][number]
                        more = located_topics(domain, observer, f'{namespace}_memory', light)
                        for kind, names in more.items():
                            has[kind] |= {name.replace('_memory', '') for name in names}
                    left: Rights = {}
                    for kind, expressions in rights.items():
                        matched = {
                            name: {e for e in expressions if fnmatchcase(name, e)}
                            for name in has[kind]
                        }
                        missing += [f'{enclave}/{node} {kind} {name}'
                                    for name, found in matched.items() if not found]
                        left[kind] = {
                            e.removeprefix(namespace)
                            for e in expressions - set().union(*matched.values())
                        }
                    unused = left if unused is None else {
                        kind: names & left[kind] for kind, names in unused.items()
                    }
                assert unused is not None
                superfluous += [f'{enclave}/{node} {kind} {name}'
                                for kind, names in unused.items() for name in names]
    assert not missing, 'the policy does not allow what the nodes do'
    assert not superfluous, 'the policy allows what no node does'


def settled(observer: Probe, node: str, namespace: str) -> Rights:
    """Return what a node has once it is whole: the graph has shown the same for a second."""
    last: Rights = {}

    def steady() -> bool:
        nonlocal last
        if (node, namespace) not in observer.get_node_names_and_namespaces():
            return False
        previous, last = last, existing(observer, node, namespace)
        if last != previous:
            return False
        observer.spin(1.0)
        return existing(observer, node, namespace) == last

    observer.spin_until(steady, timeout=90.0)
    return last

"""The SROS2 policy allows what the running nodes have, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from fnmatch import fnmatchcase
from typing import Any
from xml.etree import ElementTree

from blob_tracker.nodes import NODES
from blob_tracker.resources import config_path
import pytest
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
import security_policy
from support.node_classes import CHANGED, OPENED
from support.processes import Probe, probe, start

# Of the topics that parameters open.
pytestmark = pytest.mark.usefixtures('tf2_messages')

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
# How each enclave's process is started.
STARTS: dict[str, dict[str, object]] = dict.fromkeys(NODES, {}) | {
    'camera': {'device': '/dev/no_such_camera'},
    'pipeline': {'device': '/dev/no_such_camera'},
    'pipeline_simulator': {'source': 'simulator'},
    'pipeline_images': {'source': 'images'},
}
# What opens each topic of a coded light, which is not there at the start.
LIGHTS: dict[str, dict[str, Any]] = {
    'segmenter': {'flash.mode': 'coded', 'flash.codes': 'port:1101000,starboard:1110100'},
    'locator': {'lights': 'port,starboard'},
    'tracker': {'lights': 'port,starboard'},
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


def test_the_policy_is_that_of_the_declarations() -> None:
    """The file is what `make reference` writes."""
    assert POLICY.read_text() == security_policy.policy(), 'run `make reference`'


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


def change(observer: Probe, node: str, namespace: str, values: dict[str, Any]) -> None:
    """Set parameters of a running node."""
    request = SetParametersAtomically.Request(parameters=[
        Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
    ])
    service = f'{namespace}/{node}/set_parameters_atomically'
    answer = observer.call(SetParametersAtomically, service, request)
    assert answer.result.successful, answer.result.reason


@pytest.mark.timeout(180)  # nine processes start at once
def test_each_node_has_what_the_policy_allows_and_nothing_else(domain: int) -> None:
    """Topics, services and clients of every node, with all that is conditional opened."""
    profiles = [(enclave, profile) for enclave, element in enclaves()
                for profile in element.iter('profile')]
    nodes = {(profile.attrib['node'], f'/{enclave}') for enclave, profile in profiles}
    with probe(domain) as observer, ExitStack() as stack:
        for enclave, parameters in STARTS.items():
            arguments = ['-r', f'__ns:=/{enclave}', '-p', 'use_sim_time:=true']
            for name, value in parameters.items():
                arguments += ['-p', f'{name}:={value}']
            program = 'pipeline' if enclave.startswith('pipeline') else enclave
            stack.enter_context(start(program, domain, *arguments))
        before = settled(observer, nodes)
        for node, namespace in nodes:
            values = OPENED.get(node, {}) | CHANGED.get(node, {}) | LIGHTS.get(node, {})
            if values:
                change(observer, node, namespace, values)
        after = settled(observer, nodes)
    missing, superfluous = set(), set()
    for enclave, profile in profiles:
        node, namespace = profile.attrib['node'], f'/{enclave}'
        has = {kind: before[node, namespace][kind] | after[node, namespace][kind]
               for kind in QUESTIONS}
        for kind, expressions in allowed(profile, namespace).items():
            fitting = {name: {e for e in expressions if fnmatchcase(name, e)}
                       for name in has[kind]}
            missing |= {f'{enclave}: {node} {kind} {name}'
                        for name, found in fitting.items() if not found}
            superfluous |= {f'{enclave}: {node} {kind} {expression}'
                            for expression in expressions.difference(*fitting.values())}
    assert not missing, 'not allowed, and done: ' + '; '.join(sorted(missing))
    assert not superfluous, 'allowed, and never done: ' + '; '.join(sorted(superfluous))

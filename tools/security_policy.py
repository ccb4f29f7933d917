"""The SROS2 policy, from the declarations of the nodes: `make reference` writes it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from blob_tracker.nodes import NODES
from blob_tracker.nodes.interface import interface_of
from blob_tracker.nodes.interface.pipeline import CHAIN, HANDED_OVER, SOURCES
from blob_tracker.nodes.interface.topics import CAMERA_IMAGE, COMPRESSED_IMAGE
from blob_tracker.ros.interface import Interface, Topic

HEAD = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- SROS2 access control: what each node of blob_tracker may do, and nothing else. One enclave for
     each process; README.md tells how to make the keys. Names without a leading / are in the
     namespace ns of the profile: change that where the nodes run in one. A * stands for the name
     of a coded light. Written by `make reference` from the declarations of the nodes. -->
<!DOCTYPE policy [
  <!-- What every node has: log, parameters, simulated time. -->
  <!ENTITY node '
    <topics publish="ALLOW">
      <topic>/parameter_events</topic>
      <topic>/rosout</topic>
    </topics>
    <topics subscribe="ALLOW">
      <topic>/clock</topic>
    </topics>
    <services reply="ALLOW">
      <service>~/describe_parameters</service>
      <service>~/get_parameter_types</service>
      <service>~/get_parameters</service>
      <service>~/get_type_description</service>
      <service>~/list_parameters</service>
      <service>~/set_parameters</service>
      <service>~/set_parameters_atomically</service>
    </services>'>
]>
<policy version="0.2.0">
  <enclaves>
"""
FOOT = """\
  </enclaves>
</policy>
"""


def policy() -> str:
    """Return config/security/policy.xml."""
    return HEAD + ''.join(_enclaves()) + FOOT


def processes() -> Iterator[tuple[str, Sequence[str]]]:
    """Yield each process and the nodes in it: a node alone, or the pipeline with each source."""
    for node in NODES:
        if node != 'pipeline':
            yield node, [node]
            continue
        for index, (source, first) in enumerate(SOURCES.items()):
            yield f'{node}_{source}' if index else node, [node, *first, *CHAIN]


def _enclaves() -> Iterator[str]:
    """Yield the enclave of each process."""
    for name, nodes in processes():
        yield _enclave(name, nodes, HANDED_OVER if len(nodes) > 1 else ())


def _enclave(name: str, nodes: Sequence[str], handed_over: Sequence[Topic] = ()) -> str:
    """Return the enclave of a process with these nodes."""
    interfaces = [interface_of(node) for node in nodes]
    within = {topic for each in interfaces for topic in each.published if topic in handed_over}
    if CAMERA_IMAGE in within:
        within.add(COMPRESSED_IMAGE)
    return ''.join((
        f'    <enclave path="/blob_tracker/{name}">\n',
        '      <profiles>\n',
        *(_profile(each, within) for each in interfaces),
        '      </profiles>\n',
        '    </enclave>\n',
    ))


def _profile(interface: Interface, within: set[Topic]) -> str:
    """Return the profile of a node that takes these topics in memory."""
    subscribed = [topic for topic in interface.subscribed if topic not in within]
    return ''.join((
        f'        <profile ns="/" node="{interface.node}">\n',
        '          &node;\n',
        _rule('topic', 'subscribe', _names(interface, subscribed)),
        _rule('topic', 'publish', _names(interface, interface.published)),
        _rule('service', 'reply', (each.name for each in interface.services)),
        '        </profile>\n',
    ))


def _names(interface: Interface, topics: Iterable[Topic]) -> Iterator[str]:
    """Yield the names of topics, also those that they have for each coded light."""
    for topic in topics:
        yield topic.name
        if topic in interface.each_light:
            yield topic.name.replace('target/', 'target/*/', 1)


def _rule(kind: str, right: str, names: Iterable[str]) -> str:
    """Return what allows a right on topics or services; nothing if there are none."""
    lines = [f'            <{kind}>{name}</{kind}>\n' for name in sorted(names)]
    if not lines:
        return ''
    head = f'          <{kind}s {right}="ALLOW">\n'
    return head + ''.join(lines) + f'          </{kind}s>\n'

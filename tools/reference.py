"""
Write what follows from the declarations of the nodes: parameter file, README's tables, policy.

    make reference
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
import re

from blob_tracker.nodes import NODES
from blob_tracker.nodes.help import in_brackets, wrapped
from blob_tracker.nodes.interface import interface_of
from blob_tracker.ros.interface import Interface, Parameter
import security_policy
import yaml

ROOT = Path(__file__).parents[1]
WIDTH = 99
HEAD = """\
# Parameters of the nodes with their defaults. Copy it, change what your camera needs, and start
# the nodes with --ros-args --params-file YOURS.yaml (or params_file:=YOURS.yaml for the launch
# file). All may be set while a node runs, but for those that are marked as read-only. In brackets
# stands what a value may be. Written by `make reference` from the declarations of the nodes.
"""
CONTROLS = """\
    # Every control of the camera is a parameter as well and may be set while the node runs:
    # `v4l2-ctl --list-ctrls` names them. For example
    # exposure_time_absolute: 50
"""


def parameter_file() -> str:
    """Return config/tracker.yaml."""
    parts = [HEAD]
    for node in NODES:
        lines = [f'/**/{node}:\n', '  ros__parameters:\n']
        for parameter in interface_of(node).parameters:
            text = parameter.description + in_brackets(parameter)
            if parameter.fixed:
                text += f' Read-only: {parameter.fixed}.'
            lines += [f'    # {line}\n' for line in wrapped(text, WIDTH - len('    # '))]
            lines.append('    ' + _as_yaml(parameter))
        if node == 'camera':
            lines.append(CONTROLS)
        parts.append(''.join(lines))
    return '\n'.join(parts)


def readme(text: str) -> str:
    """Return the README with the tables between its markers written anew."""
    interfaces = [interface_of(node) for node in NODES]
    tables = {
        'topics': topics(interfaces),
        'services': services(interfaces),
        'parameters': '\n'.join(parameters(each) for each in interfaces),
    }
    for name, table in tables.items():
        marked = re.compile(f'(<!-- {name} -->\n).*?(<!-- end -->\n)', re.S)
        text, count = marked.subn(lambda found: found[1] + table + found[2], text)
        if count != 1:
            raise ValueError(f'README.md has {count} times <!-- {name} --> and its end, not 1')
    return text


def topics(interfaces: Iterable[Interface]) -> str:
    """Return the table of the topics, each with who publishes and who reads it."""
    interfaces = list(interfaces)
    published = {
        each.resolved(topic.name): topic for each in interfaces for topic in each.published
    }
    rows = []
    for name, topic in published.items():
        sources = [
            each.node for each in interfaces
            if name in (each.resolved(own.name) for own in each.published)
        ]
        readers = [each.node for each in interfaces if topic in each.subscribed]
        way = 'all' if name.startswith('/') else ', '.join(sources)
        if readers:
            way += ' → ' + ', '.join(readers)
        rows.append((f'`{name}`', topic.kind, way, topic.description))
    outside = {topic.name: topic for each in interfaces for topic in each.subscribed}
    for name, topic in outside.items():
        if name not in published:
            readers = [each.node for each in interfaces if topic in each.subscribed]
            rows.append((f'`{name}`', topic.kind, '→ ' + ', '.join(readers), topic.description))
    # What stands for all nodes comes last.
    rows.sort(key=lambda row: row[0].startswith('`/'))
    return _table(('topic', 'type', 'from → to', 'what'), rows)


def services(interfaces: Iterable[Interface]) -> str:
    """Return the table of the services."""
    return _table(
        ('service', 'type', 'node', 'what'),
        [
            (f'`{service.name}`', service.kind, each.node, service.description)
            for each in interfaces
            for service in each.services
        ],
    )


def parameters(interface: Interface) -> str:
    """Return the table of a node's parameters, folded."""
    rows = []
    for parameter in interface.parameters:
        text = parameter.description
        if parameter.fixed:
            text += f' **Read-only**: {parameter.fixed}.'
        text = ' '.join(_word(word) for word in text.split(' '))
        limits = parameter.limits or 'text'
        rows.append((f'`{parameter.name}`', f'`{parameter.value}`', limits, text))
    table = _table(('parameter', 'default', 'may be', 'what and why'), rows)
    head = f'<details><summary><b>{interface.node}</b>: {interface.caption}</summary>'
    return f'{head}\n\n{table}\n</details>\n'


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ['---'] * len(head), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


def _word(word: str) -> str:
    """Return a word that Markdown leaves alone: two ${...} would be taken for mathematics."""
    inside = word.rstrip('.,;')
    return f'`{inside}`{word[len(inside):]}' if '${' in word else word


def _as_yaml(parameter: Parameter) -> str:
    """Return one line of YAML."""
    # None: a list on the line of its name, and not the line in braces.
    style = None if isinstance(parameter.default, list) else False
    return yaml.safe_dump({parameter.name: parameter.default}, default_flow_style=style)


if __name__ == '__main__':
    (ROOT / 'config' / 'tracker.yaml').write_text(parameter_file())
    (ROOT / 'config' / 'security' / 'policy.xml').write_text(security_policy.policy())
    README = ROOT / 'README.md'
    README.write_text(readme(README.read_text()))

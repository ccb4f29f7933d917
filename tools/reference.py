"""
Write what follows from the declarations of the nodes: parameter file, their pages, policy.

    make reference
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
import re
from textwrap import fill

from blob_tracker.nodes import NODES
from blob_tracker.nodes.help import in_brackets, wrapped
from blob_tracker.nodes.interface import interface_of
from blob_tracker.ros.interface import Interface, Parameter
import security_policy
import yaml

ROOT = Path(__file__).parents[1]
DOCS = ROOT / 'docs'
WIDTH = 99
PAGE_WIDTH = 119  # columns of the documents
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
# By node: the pages of docs/ that tell how it does it, and what one does with it.
PAGES = {
    'camera': ('camera', 'new_camera', 'colour', 'analogue'),
    'segmenter': ('segmentation', 'which_light'),
    'locator': ('accuracy', 'calibration'),
    'tracker': ('prediction', 'tracking', 'servo'),
    'triangulator': ('triangulation', 'rig'),
    'constellation': ('constellation',),
    'simulator': ('lab',),
}


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


def nodes_page(text: str) -> str:
    """Return docs/nodes.md with the tables between its markers written again."""
    interfaces = [interface_of(node) for node in NODES]
    tables = {
        'nodes': _table(('node', 'what it is about'), [
            (f'[{each.node}](nodes/{each.node}.md)', each.caption) for each in interfaces
        ]),
        'topics': topics(interfaces),
        'services': services(interfaces),
    }
    for name, table in tables.items():
        marked = re.compile(f'(<!-- {name} -->\n).*?(<!-- end -->\n)', re.S)
        text, count = marked.subn(lambda found: found[1] + table + found[2], text)
        if count != 1:
            raise ValueError(f'nodes.md has {count} times <!-- {name} --> and its end, not 1')
    return text


def node_page(node: str) -> str:
    """Return docs/nodes/<node>.md: all that a node shows of itself."""
    interface = interface_of(node)
    example = '\n'.join(f'    {line}' for line in interface.examples)
    parts = [
        f'# {node}: {interface.caption}',
        '<!-- Written by `make reference` from the declarations of the nodes. -->',
        fill(interface.summary, PAGE_WIDTH),
        example,
    ]
    if node in PAGES:
        links = ', '.join(f'[{_title(page)}](../{page}.md)' for page in PAGES[node])
        parts.append(f'Read on: {links}.')
    for title, entries in interface.sections:
        rows = [
            (f'`{interface.resolved(each.name)}`', each.kind, _beside(each.description))
            for each in entries
        ]
        parts.append(f'## {title}\n\n' + _table(('name', 'type', 'what'), rows).rstrip())
    if interface.each_light:
        parts.append('Of a coded light `target/...` is `target/<name>/...`.')
    parts += [
        f'## Parameters\n\n{parameters(interface).rstrip()}',
        f'## Diagnostics\n\n{diagnostics(node).rstrip()}',
        '## Security\n\n' + security(node),
    ]
    return '\n\n'.join(parts) + '\n'


def diagnostics(node: str) -> str:
    """Return the rows of the table in docs/diagnostics.md that are of a node."""
    rows = []
    for line in (DOCS / 'diagnostics.md').read_text().splitlines():
        cells = [cell.strip() for cell in line.strip('|').split(' | ')]
        if len(cells) == 3 and {'all', node} & set(cells[1].split(', ')):
            rows.append((cells[0], _beside(cells[2])))
    return _table(('key', 'what it is'), rows)


def security(node: str) -> str:
    """Return which enclaves of config/security/policy.xml a node may run in."""
    enclaves = [name for name, nodes in security_policy.processes() if node in nodes]
    named = ', '.join(f'`/blob_tracker/{name}`' for name in enclaves)
    return fill(
        f'Enclaves that allow what is above, and nothing else: {named}; '
        '[SROS2](../../config/security/README.md).', PAGE_WIDTH, break_on_hyphens=False,
        break_long_words=False,
    )


def _title(page: str) -> str:
    """Return the title of a page of docs/, up to its colon."""
    head = (DOCS / f'{page}.md').read_text().partition('\n')[0]
    return head.removeprefix('# ').partition(':')[0]


def _beside(text: str) -> str:
    """Return a text of docs/ as it stands on a page of docs/nodes/."""
    text = _linked(text).replace('see below', 'see [Diagnostics](diagnostics.md)')
    return re.sub(r'\]\((\w+\.md)', r'](../\1', text)


def _linked(text: str) -> str:
    """Return a description with links to the pages of docs/ that it names."""
    return re.sub(r'\bdocs/(\w+\.md)', r'[\1](\1)', text)


def topics(interfaces: Iterable[Interface]) -> str:
    """Return the table of the topics, each with who publishes and who reads it."""
    interfaces = list(interfaces)
    published = {
        each.resolved(topic.name): topic for each in interfaces for topic in each.published
    }
    speaking = [each.node for each in interfaces if each.published]
    rows = []
    for name, topic in published.items():
        sources = [
            each.node for each in interfaces
            if name in (each.resolved(own.name) for own in each.published)
        ]
        readers = [each.node for each in interfaces if topic in each.subscribed]
        way = 'all' if sources == speaking else ', '.join(sources)
        if readers:
            way += ' → ' + ', '.join(readers)
        rows.append((f'`{name}`', topic.kind, way, _linked(topic.description)))
    outside = {topic.name: topic for each in interfaces for topic in each.subscribed}
    for name, topic in outside.items():
        if name not in published:
            readers = [each.node for each in interfaces if topic in each.subscribed]
            way = '→ ' + ', '.join(readers)
            rows.append((f'`{name}`', topic.kind, way, _linked(topic.description)))
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
    """Return the table of a node's parameters."""
    rows = []
    for parameter in interface.parameters:
        text = parameter.description
        if parameter.fixed:
            text += f' **Read-only**: {parameter.fixed}.'
        text = ' '.join(_word(word) for word in _beside(text).split(' '))
        limits = parameter.limits or 'text'
        rows.append((f'`{parameter.name}`', f'`{parameter.value}`', limits, text))
    return _table(('parameter', 'default', 'may be', 'what and why'), rows)


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
    PAGE = DOCS / 'nodes.md'
    PAGE.write_text(nodes_page(PAGE.read_text()))
    for each in NODES:
        (DOCS / 'nodes' / f'{each}.md').write_text(node_page(each))

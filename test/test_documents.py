"""README, CONTRIBUTING, DEVELOPING and docs/ speak of what is there: names, files, sentences."""

from __future__ import annotations

import argparse
import ast
from collections.abc import Iterator
import os
from pathlib import Path
import re
import shlex
from typing import NamedTuple

from blob_tracker.__main__ import command, COMMANDS
from blob_tracker.commands.calibrate import CALIBRATIONS
from blob_tracker.nodes import NODES
from blob_tracker.nodes.interface import interface_of
import pytest

ROOT = Path(__file__).parents[1]
DOCUMENTS = [
    ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', ROOT / 'DEVELOPING.md',
    ROOT / 'config' / 'security' / 'README.md', ROOT / 'findings' / 'README.md',
    *sorted((ROOT / 'docs').rglob('*.md')),
    ROOT / 'doc' / 'api' / 'index.md',
]
DOC = ROOT / 'doc'
# Of Markdown and of reStructuredText.
CONTENTS = re.compile(r'{toctree}\n([^`]*)```|toctree::\n((?:   .*\n|\n)*)')
HOLE = None  # in a sentence of the code: what is put in when it is said


class Quote(NamedTuple):
    """Some words of a document."""

    document: str
    text: str

    def __str__(self) -> str:
        return f'{self.document}: {self.text}'


def quotes(pattern: str) -> list[Quote]:
    """Return what a pattern finds in the documents, lines that end in a backslash joined."""
    found = []
    for path in DOCUMENTS:
        text = re.sub(r'\\\n\s*', '', path.read_text())
        found += [Quote(path.name, match) for match in re.findall(pattern, text)]
    assert found, f'no document has {pattern}'
    return found


def words(command: str) -> list[str]:
    """Return the words of a command line, without its comment."""
    return shlex.split(command, comments=True)


def parser() -> argparse.ArgumentParser:
    """Return the parser of `python3 -m blob_tracker` with all its commands."""
    whole = argparse.ArgumentParser(exit_on_error=False)
    commands = whole.add_subparsers(required=True)
    for name in COMMANDS:
        command(name).add_arguments(commands.add_parser(name))
    return whole


def test_command_lines_are_understood(capsys: pytest.CaptureFixture[str]) -> None:
    """Each is given to the parser that would read it."""
    commands = parser()
    named = [[name] for name in COMMANDS] + [['calibrate', name] for name in CALIBRATIONS]
    for quote in quotes(r'python3? -m blob_tracker ([^\n`|]+)'):
        given = words(quote.text)
        if given in (['calibrate', 'WHAT'], ['COMMAND']):
            continue  # the general form
        if given in named:
            given = [*given, '--help']  # it is only named; its help ends the parser, well
        try:
            commands.parse_args(given)
        except SystemExit as ended:
            assert ended.code == 0, f'{quote}: {capsys.readouterr().err}'


def test_executables_and_their_parameters_exist() -> None:
    """In `ros2 run`, `ros2 param` and `-p NAME:=VALUE`; the camera also has its controls."""
    for quote in quotes(r'ros2 run blob_tracker ([^\n`|]+)'):
        node, *rest = words(quote.text)
        assert node in NODES, quote
        known = {each.name for name in _within(node) for each in interface_of(name).parameters}
        for word in rest:
            name, assigned, _ = word.partition(':=')
            if assigned and not name.startswith(('__', 'qos_overrides.')):
                assert name in known, quote
    for quote in quotes(r'ros2 param \w+ (/\w+[^\n`|]*)'):
        node, *rest = words(quote.text)
        names = {each.name for each in interface_of(node[1:]).parameters}
        assert not rest or node == '/camera' or rest[0] in names, quote


def _within(node: str) -> tuple[str, ...]:
    """Return the nodes of the process that an executable is."""
    return NODES if node == 'pipeline' else (node,)


def test_launch_arguments_exist() -> None:
    """Of each launch file, by the declarations in it."""
    for quote in quotes(r'ros2 launch blob_tracker ([^\n`|]+)'):
        file, *rest = words(quote.text)
        tree = ast.parse((ROOT / 'launch' / file).read_text())
        names = {
            ast.literal_eval(call.args[0]) for call in ast.walk(tree)
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)
            and call.func.id == 'DeclareLaunchArgument'
        }
        assert {word.partition(':=')[0] for word in rest} <= names, quote


def test_topics_and_services_exist() -> None:
    """Those that are echoed, shown or called."""
    topics: set[str] = set()
    services: dict[str, str] = {}
    for interface in map(interface_of, NODES):
        topics |= {'/' + interface.resolved(each.name).lstrip('/') for each in interface.published}
        services |= {'/' + each.name: each.kind for each in interface.services}
    for quote in quotes(r'ros2 topic \w+ (/[\w/]+)') + quotes(r'rqt_image_view (/[\w/]+)'):
        assert quote.text in topics, quote
    for quote in quotes(r'ros2 service call (/\S+ [\w/]+)'):
        name, kind = quote.text.split()
        assert services[name].replace('/', '/srv/') == kind, quote


def test_make_targets_and_variables_exist() -> None:
    """`make TARGET VARIABLE=...`, as code."""
    makefile = (ROOT / 'Makefile').read_text()
    targets = set(re.findall(r'^([a-z]+):', makefile, re.M))
    for quote in quotes(r'(?:^|(?<=`)|(?<=\n {4}))make ([a-z]+(?: +[A-Z_]+=\S+)*)'):
        target, *variables = quote.text.split()
        assert target in targets, quote
        for variable in variables:
            assert re.search(rf'\b{variable.partition("=")[0]}\b', makefile), quote


def test_links_lead_somewhere() -> None:
    """To a file or folder here, and to a heading in it."""
    for path in DOCUMENTS:
        for link in re.findall(r'\]\(([^)\s]+)\)', path.read_text()):
            if link.startswith(('http://', 'https://')):
                continue
            place, _, heading = link.partition('#')
            target = (path.parent / place) if place else path
            assert target.exists(), f'{path.name}: {link}'
            assert not heading or heading in _headings(target), f'{path.name}: {link}'


def keys_shown() -> set[str]:
    """Return what nodes show and count in their diagnostics, as patterns: a hole is anything."""
    found = set()
    package = ROOT / 'blob_tracker'
    for path in (*(package / 'nodes').rglob('*.py'), *(package / 'ros').rglob('*.py')):
        if '.show(' not in path.read_text() and '.count(' not in path.read_text():
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            keys: list[ast.expr] = []
            if isinstance(node, ast.Call) and _shows(node):
                keys = node.args[:1]
            elif isinstance(node, ast.For) and isinstance(node.iter, ast.Tuple):
                # for key, value in (('state', state), ...): health.show(name + key, value)
                if any(isinstance(each, ast.Call) and _shows(each) for each in ast.walk(node)):
                    keys = [row.elts[0] for row in node.iter.elts if isinstance(row, ast.Tuple)]
            for key in keys:
                parts = key.values if isinstance(key, ast.JoinedStr) else [key]
                pieces = [piece for part in parts for piece in _pieces(part)]
                found.add(''.join('.*' if each is HOLE else re.escape(each) for each in pieces))
    return found


def _shows(call: ast.Call) -> bool:
    """Tell whether a call is one of `show` or `count` of a node's health."""
    function = call.func
    return (
        isinstance(function, ast.Attribute) and function.attr in ('show', 'count', 'tally')
        and ast.unparse(function.value) in ('self', 'health', 'self._health')
    )


def test_each_key_of_the_diagnostics_is_explained() -> None:
    """In the table of docs/diagnostics.md, from which each node's page has its own."""
    table = (ROOT / 'docs' / 'diagnostics.md').read_text()
    rows = re.findall(r'^\| (`.+?) \| [\w, ]+ \|', table, re.M)
    explained = [key for row in rows for key in re.findall(r'`([^`]+)`', row)]
    keys = keys_shown()
    assert 'SNR' in keys and 'CPU\\ \\(%\\)' in keys  # by both ways
    for key in keys:
        assert any(re.fullmatch(key, each) for each in explained), key


def test_the_readme_is_a_front_door() -> None:
    """No longer than is read at one go."""
    assert len((ROOT / 'README.md').read_text().splitlines()) <= 150


def test_the_site_is_whole() -> None:
    """Each page is in a table of contents of doc/, once, and what one names is there."""
    listed: list[Path] = []
    for path in (DOC / 'index.rst', DOC / 'api' / 'index.md'):
        for contents in CONTENTS.findall(path.read_text()):
            for entry in re.findall(r'^ *([^:\s].*)$', ''.join(contents), re.M):
                found = [*path.parent.glob(f'{entry}.md'), *path.parent.glob(f'{entry}.rst')]
                assert found, f'{path.name}: {entry}'
                listed += [each.resolve() for each in found]
    assert len(listed) == len(set(listed))
    pages = {*DOCUMENTS, ROOT / 'CHANGELOG.rst', *(DOC / 'api').iterdir()} - {ROOT / 'README.md'}
    assert pages == set(listed)


def test_findings_are_listed_and_can_be_run() -> None:
    """Each once; they are not run here, which takes a quarter of an hour and a network."""
    scripts = sorted((ROOT / 'findings').glob('*.sh'))
    listed = re.findall(r'^\| `(\w+)` \|', (ROOT / 'findings' / 'README.md').read_text(), re.M)
    assert listed == [script.stem for script in scripts]
    for script in scripts:
        assert os.access(script, os.X_OK), script.name
        for part in ('# Expected: ', '# Happens: ', '# Matters: ', 'set -euo pipefail', 'trap '):
            assert f'\n{part}' in script.read_text(), f'{script.name} has no line {part}'


def _headings(path: Path) -> set[str]:
    """Return the anchors of a Markdown file's headings."""
    return {
        re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-')
        for heading in re.findall(r'^#+ (.+)$', path.read_text(), re.M)
    }


def said_in_tables() -> list[Quote]:
    """Return what tables say that nodes say: sentences, and keys of the diagnostics."""
    found = []
    for path in DOCUMENTS:
        if path.parent.name == 'nodes':
            continue  # what it quotes is written from docs/diagnostics.md
        column = ''
        for line in path.read_text().splitlines():
            if not line.startswith('|'):
                column = ''
                continue
            first = line.split('|')[1].strip()
            if set(first) <= set('-: '):
                continue  # the line under the head
            if column == 'it says':
                found.append(Quote(path.name, first))
            elif column in ('what you see', 'key'):
                said = [Quote(path.name, each) for each in re.findall(r'`([^`]+)`', first)]
                assert said, f'{path.name}: no sentence to look for, in `...`: {first}'
                found += said
            column = column or first.lower()
    return found


@pytest.fixture(scope='module')
def sentences() -> list[list[str | None]]:
    """Give every text in the code that may be said, as characters and holes."""
    found = []
    for path in sorted((ROOT / 'blob_tracker').rglob('*.py')):
        if path.parent.name == 'interface':
            continue  # descriptions are shown, not said
        tree = ast.parse(path.read_text())
        skipped: set[ast.AST] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                skipped.add(node.value)  # a docstring
            if isinstance(node, ast.JoinedStr):
                skipped |= set(node.values)
        for node in ast.walk(tree):
            if node in skipped:
                continue
            if isinstance(node, ast.JoinedStr):
                found.append([character for part in node.values for character in _pieces(part)])
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.append(list(_pieces(node)))
    return found


def _pieces(part: ast.expr) -> Iterator[str | None]:
    """Yield the characters of a literal; a hole for what is put in."""
    if not isinstance(part, ast.Constant):
        yield HOLE
        return
    for piece in re.split(r'(\{[^}]*\})', str(part.value)):  # of str.format
        if piece.startswith('{'):
            yield HOLE
        else:
            yield from piece


def may_be_said(text: str, sentence: list[str | None]) -> bool:
    """
    Tell whether a text is a part of a sentence with something in its holes.

    What is put in is less than half of the text, or a hole would fit anything.
    """
    # Place in the sentence -> the most characters of the text that stood there literally.
    places = dict.fromkeys(range(len(sentence)), 0)
    for character in text:
        following: dict[int, int] = {}
        for place, literal in places.items():
            while place < len(sentence) and sentence[place] is HOLE:
                following[place] = max(following.get(place, 0), literal)
                place += 1
            if place < len(sentence) and sentence[place] == character:
                following[place + 1] = max(following.get(place + 1, 0), literal + 1)
        places = following
    return any(2 * literal > len(text) for literal in places.values())


STILTED = re.compile(r'\b(afresh|anew|cannot be told|nobody tells|for want of)\b')


def test_sentences_are_plain(sentences: list[list[str | None]]) -> None:
    """The words of the glossary, in documents and in what is said."""
    for path in DOCUMENTS:
        if path.name != 'glossary.md':  # which names the words that are not to be used
            assert not STILTED.search(path.read_text()), path.name
    for sentence in sentences:
        text = ''.join(each or '' for each in sentence)
        assert not STILTED.search(text), text


def test_a_sentence_is_recognized() -> None:
    """With what is put in, and not by what is put in alone."""
    sentence = [*'no frame for ', HOLE, *' s from ', HOLE]
    assert may_be_said('no frame for 1.0 s from /dev/video0', sentence)
    assert may_be_said('frame for', sentence)
    assert not may_be_said('no frames for', sentence)
    assert not may_be_said('something else altogether', sentence)


@pytest.mark.parametrize('quote', said_in_tables(), ids=str)
def test_what_is_said_to_be_said_is_said(
    quote: Quote, sentences: list[list[str | None]]
) -> None:
    """Each part of it between dots is in one sentence of the code."""
    for part in filter(None, (part.strip(' ,') for part in quote.text.split('...'))):
        assert any(may_be_said(part, sentence) for sentence in sentences), part

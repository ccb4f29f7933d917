"""What a command line gives to parameters, and what of it reaches no node or loses to another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import re
from typing import Any

ALL = '/**'  # the key of every node


@dataclass(frozen=True)
class Source:
    """
    What one word of the command line gives to the nodes of one name.

    Parameters
    ----------
    words : str
        The file's name, or the assignment as it stands.
    is_file : bool
        Whether it is a file.
    key : str
        Whom it is for: a node's full name, * and ** stand for parts of it.
    values : mapping
        Text or list of each parameter, by name.

    """

    words: str
    is_file: bool
    key: str
    values: Mapping[str, Any]

    def is_for(self, node: str) -> bool:
        """Tell whether a node of this full name takes it."""
        key = self.key if self.key.startswith('/') else f'/{self.key}'
        parts = (
            {'/**': '(/[^/]+)*', '**': '.*', '*': '[^/]+'}.get(part, re.escape(part))
            for part in re.split(r'(/\*\*|\*\*|\*)', key)
        )
        return re.fullmatch(''.join(parts), node) is not None


def sources(words: Sequence[str]) -> Iterator[Source]:
    """
    Yield what a command line gives, in its order.

    Parameters
    ----------
    words : sequence of str
        As in sys.argv. What rcl refuses is left out: it ends the start by itself.

    """
    ours = False  # whether the words are ROS' own
    for word, value in zip(words, [*words[1:], ''], strict=True):
        if word in ('--ros-args', '--'):
            ours = word == '--ros-args'
        elif ours and word == '--params-file':
            yield from _of_file(value)
        elif ours and word in ('-p', '--param') and ':=' in value:
            name, _, text = value.partition(':=')
            key, separator, own = name.partition(':')
            yield Source(
                f'-p {value}', False, key if separator else ALL, {own if separator else name: text}
            )


def unreadable(words: Sequence[str]) -> str:
    """Say which parameter file of a command line cannot be read; '' where all can."""
    for path in _files(words):
        try:
            Path(path).read_bytes()
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            return f"the parameter file '{path}' cannot be read: {reason}"
    return ''


def no_yaml(words: Sequence[str]) -> str:
    """Say where a parameter file of a command line is no YAML, which rcl does not; else ''."""
    import yaml  # see `_of_file`

    for path in _files(words):
        try:
            yaml.load(Path(path).read_bytes(), yaml.BaseLoader)
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            place = f', line {mark.line + 1}, column {mark.column + 1}' if mark else ''
            return f'{path}{place}: {error.problem}'
        except (OSError, ValueError):  # which is told elsewhere
            continue
    return ''


def remarks(given: Sequence[Source], nodes: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """
    Return what to say of values that reach none of the nodes, or lose to others.

    Parameters
    ----------
    given : sequence of Source
        What the command line gives.
    nodes : mapping
        The values that start-up gave to each node of this process, by its full name.

    """
    here = ' and '.join(nodes)
    said = []
    for words in dict.fromkeys(each.words for each in given):
        parts = [each for each in given if each.words == words]
        if any(part.is_for(node) for part in parts for node in nodes):
            continue
        keys = ', '.join(part.key for part in parts)
        said.append(
            f'{words} holds nothing for {here}: it is keyed to {keys}; write {ALL}: for any node, '
            f'or the full name, {next(iter(nodes))}:' if parts[0].is_file else
            f'{words} is for {keys}, and here is {here}: it has no effect'
        )
    for node, values in nodes.items():
        said += _overridden([each for each in given if each.is_for(node)], values)
    return list(dict.fromkeys(said))


def from_files(given: Sequence[Source], node: str) -> set[str]:
    """Return the names of the parameters that files alone give to a node."""
    files, words = (
        {name for each in given if each.is_file is is_file and each.is_for(node)
         for name in each.values}
        for is_file in (True, False)
    )
    return files - words


def _files(words: Sequence[str]) -> Iterator[str]:
    """Yield the parameter files of a command line."""
    ours = False  # whether the words are ROS' own
    for word, value in zip(words, [*words[1:], ''], strict=True):
        if word in ('--ros-args', '--'):
            ours = word == '--ros-args'
        elif ours and word == '--params-file':
            yield value


def _overridden(given: Sequence[Source], values: Mapping[str, Any]) -> Iterator[str]:
    """Yield what to say of assignments that lose to a file: rcl does not take them last."""
    assigned = {name: each for each in given if not each.is_file for name in each.values}
    for name, source in assigned.items():
        value = values.get(name)
        if _value(source.values[name]) == value:
            continue
        for other in given:
            if other.is_file and name in other.values and _value(other.values[name]) == value:
                yield (
                    f'{source.words} is overridden: {name} is {value!r:.80}, by {other.words}, '
                    f'under {other.key}; give the file first and all -p after it'
                )
                break


def _value(text: Any) -> Any:
    """Return the value of a parameter's text, as far as YAML and rcl agree."""
    if not isinstance(text, str):
        return text
    import yaml

    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    try:
        return float(value) if isinstance(value, str) and re.match(r'[-+.\d]', value) else value
    except ValueError:
        return value


def _of_file(path: str) -> Iterator[Source]:
    """Yield what a file gives to the nodes that it names."""
    import yaml  # only where there is something to read: it takes as long as a node's parameters

    try:
        # All values as they are written: numbers, too.
        content = yaml.load(Path(path).read_text(encoding='utf-8'), yaml.BaseLoader)
    except (OSError, ValueError, yaml.YAMLError):
        return
    found = list(_keyed(content, ''))
    yield from (Source(path, True, key, values) for key, values in found)
    if not found:
        yield Source(path, True, 'no node', {})


def _keyed(content: Any, key: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each node's key in a file with its values."""
    if not isinstance(content, dict):
        return
    for name, inner in content.items():
        if name == 'ros__parameters':
            yield key, dict(_flat(inner, ''))
        else:
            yield from _keyed(inner, f'{key}/{name}'.replace('//', '/') if key else name)


def _flat(content: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield the values of nested groups by their names with dots."""
    if not isinstance(content, dict):
        return
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{prefix}{name}.')
        else:
            yield f'{prefix}{name}', value

"""What `ros2 run blob_tracker NODE --help` prints: a node's interface on one screen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from textwrap import fill, wrap

from blob_tracker.ros.interface import Interface, Parameter

LEAST_TEXT = 24  # columns for a description, however narrow the terminal
UNBROKEN = '\u00a0'  # a space at which no line ends


def help_text(interface: Interface, width: int) -> str:
    """
    Return the help of a node.

    Parameters
    ----------
    interface : Interface
        What the node shows.
    width : int
        Columns of the terminal.

    """
    parts = [
        fill(
            f'usage: ros2 run blob_tracker {interface.node} [--ros-args -p NAME:=VALUE '
            '--params-file FILE -r OLD:=NEW]',
            width,
        ),
        fill(interface.summary, width),
    ]
    for title, entries in interface.sections:
        rows = [
            (interface.resolved(entry.name), entry.kind, _short(entry.description))
            for entry in entries
        ]
        parts.append(f'{title}\n' + _table(rows, width))
    parts.append(
        'Parameters, defaults and what they may be; '
        f'`ros2 param describe /{interface.node} NAME` says more\n'
        + _table([_row(parameter) for parameter in interface.parameters], width)
    )
    parts.append('For example, and to change one while it runs\n' + '\n'.join(
        f'  {example}' for example in interface.examples
    ))
    return '\n\n'.join(parts)


def _row(parameter: Parameter) -> tuple[str, str, str]:
    """Return name, default and the first sentence of the description."""
    text = parameter.description.partition('. ')[0].removesuffix('.') + in_brackets(parameter)
    if parameter.fixed:
        text += f'; read-only: {parameter.fixed}'
    return parameter.name, parameter.value, text


def in_brackets(parameter: Parameter) -> str:
    """Return what a value may be, as it follows on the description."""
    if not parameter.limits:
        return ''
    if parameter.choices:
        return f' [{parameter.limits}]'
    return f' [{parameter.limits.replace(" ", UNBROKEN)}]'


def wrapped(text: str, width: int) -> list[str]:
    """Return lines of a text; a range stays on one of them, and so does a path."""
    lines = wrap(text, width, break_on_hyphens=False, break_long_words=False)
    return [line.replace(UNBROKEN, ' ') for line in lines]


def _short(description: str) -> str:
    """Return what comes first in a description, without the marks of Markdown."""
    return description.partition('; ')[0].replace('`', '').replace('**', '')


def _table(rows: Iterable[Sequence[str]], width: int) -> str:
    """Return rows of three columns, the last one wrapped within the width."""
    rows = list(rows)
    first, second = (max(len(row[column]) for row in rows) for column in (0, 1))
    lines = []
    for name, value, text in rows:
        begin = f'  {name:{first}}  {value:{second}}  '
        column = wrapped(text, max(width - len(begin), LEAST_TEXT))
        lines += [begin + column[0], *(' ' * len(begin) + line for line in column[1:])]
    return '\n'.join(lines)

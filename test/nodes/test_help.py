"""What the executables say of themselves."""

from __future__ import annotations

import os
import subprocess

from blob_tracker.nodes import NODES
from blob_tracker.nodes.help import help_text
from blob_tracker.nodes.interface import interface_of
from blob_tracker.ros.interface import Service, Topic
import pytest
from support.processes import executable
from support.slowness import slowness


@pytest.mark.parametrize('node', NODES)
@pytest.mark.parametrize('width', [60, 80, 99])
def test_help_has_all_that_the_node_shows(node: str, width: int) -> None:
    """Each name stands at the begin of a line with its default, no line is too long."""
    interface = interface_of(node)
    text = help_text(interface, width)
    starts = [line.split()[:2] for line in text.splitlines() if line.startswith('  ')]
    for parameter in interface.parameters:
        assert [parameter.name, parameter.value] in starts
        assert parameter.fixed in ' '.join(text.split())
    shown: list[Topic | Service] = [
        *interface.subscribed, *interface.published, *interface.services
    ]
    for each in shown:
        assert [interface.resolved(each.name), each.kind] in starts
    assert all(example in text for example in interface.examples)
    if width == 99:
        assert max(map(len, text.splitlines())) <= width
        assert len(text.splitlines()) <= 100  # two screens; the segmenter has the most to say


def test_a_range_stays_on_its_line() -> None:
    """Where it would be cut in two, it goes to the next line whole."""
    for width in range(50, 99):
        assert '[3 to 1000]' in help_text(interface_of('segmenter'), width)


@pytest.mark.parametrize('words', [['--help'], ['-h', '--ros-args', '-p', 'device:=/dev/video1']])
def test_the_executable_prints_it_and_ends(words: list[str]) -> None:
    """Without ROS: there is no middleware of this name."""
    environment = {**os.environ, 'COLUMNS': '90', 'RMW_IMPLEMENTATION': 'rmw_none'}
    result = subprocess.run(
        [executable('camera'), *words],
        capture_output=True, text=True, timeout=60 * slowness(), env=environment,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout == help_text(interface_of('camera'), 90) + '\n'

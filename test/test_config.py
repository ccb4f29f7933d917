"""The files in config/ and docs/nodes/ say what is declared; Fast DDS reads its profile."""

from __future__ import annotations

import os
from pathlib import Path
import re
import subprocess
import sys
from typing import Any
from xml.etree import ElementTree

from blob_tracker.nodes import NODES
from blob_tracker.nodes.interface import interface_of
from blob_tracker.resources import config_path
import pytest
import reference
import yaml


DOCS = Path(__file__).parents[1] / 'docs'
# A node in a process whose files may have no more than 1 MiB, those of shared memory, too.
SMALL_FILES = """
import resource
import signal
import rclpy
resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
rclpy.init(args=['--ros-args', '--disable-external-lib-logs'])
rclpy.create_node('small')
"""


def test_parameter_file_is_that_of_the_declarations() -> None:
    """tracker.yaml is what `make reference` writes, and gives each parameter its default."""
    text = config_path('tracker.yaml').read_text()
    assert text == reference.parameter_file(), 'run `make reference`'
    assert max(map(len, text.splitlines())) <= reference.WIDTH
    assert yaml.safe_load(text) == {
        f'/**/{node}': {'ros__parameters': {
            parameter.name: parameter.default for parameter in interface_of(node).parameters
        }}
        for node in NODES
    }


def test_tables_of_the_nodes_are_those_of_the_declarations() -> None:
    """Nodes, topics and services are what `make reference` writes."""
    text = (DOCS / 'nodes.md').read_text()
    assert text == reference.nodes_page(text), 'run `make reference`'
    assert {path.stem for path in (DOCS / 'nodes').iterdir()} == set(NODES)


@pytest.mark.parametrize('node', NODES)
def test_the_page_of_a_node_is_that_of_its_declaration(node: str) -> None:
    """It is what `make reference` writes, with each parameter, topic and service."""
    text = (DOCS / 'nodes' / f'{node}.md').read_text()
    assert text == reference.node_page(node), 'run `make reference`'
    interface = interface_of(node)
    shown = [each.name for each in interface.parameters]
    shown += [each.name for each in interface.services]
    assert all(f'| `{name}` |' in text for name in shown)
    assert '`memory (MB)`' in text, 'the diagnostics of all nodes'
    assert '`/blob_tracker/' in text


@pytest.mark.parametrize('node', NODES)
def test_defaults_are_within_their_ranges(node: str) -> None:
    """And each parameter has a reason to be there."""
    parameters = interface_of(node).parameters
    assert len({parameter.name for parameter in parameters}) == len(parameters)
    for parameter in parameters:
        assert len(parameter.description) >= 15
        if parameter.least is not None:
            default: Any = parameter.default
            assert parameter.least <= default <= parameter.most
        if parameter.choices:
            assert parameter.default in parameter.choices


def test_profile_holds_a_burst_of_large_images() -> None:
    """The shared-memory segment holds ten frames of 1920 x 1200 at least."""
    space = {'dds': 'http://www.eprosima.com'}
    root = ElementTree.parse(config_path('fastdds.xml')).getroot()
    size = int(root.find('.//dds:segment_size', space).text)
    assert size >= 10 * 1920 * 1200


def test_the_smaller_profile_differs_in_the_segment_alone() -> None:
    """Whole frames do not fit into it; one 1920 x 1200 picture of a debug_image does."""
    found = {}
    for name in ('fastdds.xml', 'fastdds_small.xml'):
        _, _, text = config_path(name).read_text().partition('<dds')
        found[name] = re.split(r'<segment_size>(\d+)</segment_size>', text)
    (*large, end), (*small, small_end) = found.values()
    assert (large[0], end) == (small[0], small_end)
    assert 1920 * 1200 * 3 < int(small[1]) < int(large[1])


def test_errors_of_fast_dds_are_on_the_standard_error() -> None:
    """The standard output is for what a program was asked for: here the segment cannot be made."""
    ran = subprocess.run(
        [sys.executable, '-c', SMALL_FILES], capture_output=True, text=True, check=True,
        env={**os.environ, 'FASTRTPS_DEFAULT_PROFILES_FILE': str(config_path('fastdds.xml'))},
    )
    assert 'Failed to create segment' in ran.stderr
    assert ran.stdout == ''


def test_a_file_that_is_not_there_is_named() -> None:
    """The sentence has the name and the folder."""
    with pytest.raises(FileNotFoundError, match='no_such.yaml is not in '):
        config_path('no_such.yaml')

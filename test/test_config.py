"""The files in config/ say what the nodes declare, and Fast DDS reads its profile."""

from __future__ import annotations

from importlib import import_module
from xml.etree import ElementTree

from blob_tracker.resources import config_path
import pytest
import yaml


@pytest.mark.parametrize('node', ['camera', 'segmenter', 'locator', 'pipeline'])
def test_parameter_file_holds_every_default(node: str) -> None:
    """tracker.yaml has each parameter of each node with the default of its declaration."""
    content = yaml.safe_load(config_path('tracker.yaml').read_text())
    parameters = import_module(f'blob_tracker.nodes.interface.{node}').PARAMETERS
    assert content[f'/**/{node}']['ros__parameters'] == {p.name: p.default for p in parameters}


@pytest.mark.parametrize('node', ['camera', 'segmenter', 'locator', 'pipeline', 'simulator'])
def test_defaults_are_within_their_ranges(node: str) -> None:
    """And each parameter has a reason to be there."""
    for parameter in import_module(f'blob_tracker.nodes.interface.{node}').PARAMETERS:
        assert len(parameter.description) >= 15
        if parameter.least is not None:
            assert parameter.least <= parameter.default <= parameter.most
        if parameter.choices:
            assert parameter.default in parameter.choices


def test_profile_holds_a_burst_of_large_images() -> None:
    """The shared-memory segment holds ten frames of 1920 x 1200 at least."""
    space = {'dds': 'http://www.eprosima.com'}
    root = ElementTree.parse(config_path('fastdds.xml')).getroot()
    size = int(root.find('.//dds:segment_size', space).text)
    assert size >= 10 * 1920 * 1200


def test_a_file_that_is_not_there_is_named() -> None:
    """The sentence has the name and the folder."""
    with pytest.raises(FileNotFoundError, match='no_such.yaml is not in '):
        config_path('no_such.yaml')

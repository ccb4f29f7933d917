"""Parameters as people give them: to the wrong node, twice, without a value, or from a dump."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.parameter import parameter_value_to_python
from support.processes import PATIENCE, Probe, probe, start
import yaml


@pytest.mark.parametrize(('content', 'sentence'), [
    ('flash.codes: []', "'flash.codes' is [] or empty, which is not a value; it must be a string"),
    ('mask_url:', 'No value at line 3'),
    ('flash.codes: 0110', "'flash.codes' is 72; it must be a string; put it in quotes"),
    ('flash.codes: [a, b]', "it is one text and no list: flash.codes: 'a,b'"),
    ('flash.codes: [[a, b], [c]]', 'no value is a list of lists or of several kinds: names are'),
    ('flash.codes: [1, a]', "names are one text, 'a,b'"),
    ('\tflash.codes: a', "my.yaml, line 3, column 5: found character '\\t' that cannot start"),
])
def test_what_is_no_value_ends_with_a_sentence(
    content: str, sentence: str, domain: int, tmp_path: Path
) -> None:
    """Exit code 2 and no trace."""
    file = tmp_path / 'my.yaml'
    file.write_text(f'/**:\n  ros__parameters:\n    {content}\n')
    with start('segmenter', domain, '--params-file', str(file)) as process:
        assert process.wait(PATIENCE) == 2
    assert sentence in process.output
    assert 'Traceback' not in process.output


def test_what_has_no_effect_is_said_at_the_start(domain: int, tmp_path: Path) -> None:
    """A file for another namespace, and an assignment that a file takes back."""
    other, last = tmp_path / 'other.yaml', tmp_path / 'last.yaml'
    other.write_text('/left/segmenter:\n  ros__parameters:\n    min_snr: 9.0\n')
    last.write_text('/**:\n  ros__parameters:\n    min_snr: 8.0\n')
    words = ('-p', 'min_snr:=9.0', '--params-file', str(other), '--params-file', str(last))
    with probe(domain) as node, start('segmenter', domain, *words) as process:
        node.spin_until(lambda: 'segmenter' in node.get_node_names())
        assert dump(node, 'segmenter')['min_snr'] == 8.0  # rcl takes what comes later
        process.end()
    assert f'{other} holds nothing for /segmenter: it is keyed to /left/segm' in process.output
    assert f'-p min_snr:=9.0 is overridden: min_snr is 8.0, by {last}' in process.output


def dump(node: Probe, name: str) -> dict[str, Any]:
    """Return all parameters of a node."""
    names = node.call(
        ListParameters, f'/{name}/list_parameters', ListParameters.Request()).result.names
    values = node.call(
        GetParameters, f'/{name}/get_parameters', GetParameters.Request(names=names)).values
    return dict(zip(names, map(parameter_value_to_python, values), strict=True))


def test_a_dump_is_a_file_to_start_with(domain: int, tmp_path: Path) -> None:
    """Of all nodes of a process, with QoS overrides and what rclpy declares by itself."""
    nodes = 'pipeline', 'simulator', 'segmenter', 'locator', 'tracker'
    small = {'width': 160, 'height': 120, 'use_sim_time': 'false'}
    file = tmp_path / 'dump.yaml'
    with probe(domain) as node:
        with start('pipeline', domain, source='simulator', **small):
            before = {name: dump(node, name) for name in nodes}
        content: dict[str, Any] = {}
        for name, values in before.items():
            for each, value in values.items():
                # As ros2 param dump nests them.
                place = content.setdefault(f'/{name}', {}).setdefault('ros__parameters', {})
                *groups, last = each.split('.')
                for group in groups:
                    place = place.setdefault(group, {})
                place[last] = value
        file.write_text(yaml.dump(content))
        assert 'qos_overrides' in file.read_text()
        with start('pipeline', domain, '--params-file', str(file)) as process:
            node.spin_until(lambda: not process.running or 'simulator' in node.get_node_names())
            assert {name: dump(node, name) for name in nodes} == before
            process.end()
    assert 'no effect' not in process.output
    assert 'overridden' not in process.output

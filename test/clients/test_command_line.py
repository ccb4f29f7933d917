"""What a user types: `ros2 run`, `topic echo`, `param` and `service call`."""

from __future__ import annotations

from pathlib import Path
import subprocess

from geometry_msgs.msg import Vector3Stamped
import pytest
from support.clients import needs
from support.processes import PATIENCE, probe, Process, start
from support.slowness import slowness
import yaml

needs('ros2cli', 'ros2param', 'ros2run', 'ros2service', 'ros2topic')

# The daemon would outlive the test, and its domain be another's next.
DIRECT = ('--no-daemon', '--spin-time', '3')


@pytest.fixture
def ros2(domain: int, monkeypatch: pytest.MonkeyPatch):
    """Give a function that runs a command to its end and returns what it printed."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))

    def run(*arguments: str) -> str:
        ended = subprocess.run(
            ['ros2', *arguments], capture_output=True, text=True, check=False,
            timeout=PATIENCE * slowness(),
        )
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    return run


@pytest.mark.parametrize('name', ['camera', 'segmenter', 'locator', 'tracker', 'pipeline'])
def test_run_starts_a_node_and_ctrl_c_ends_it(name: str, domain: int) -> None:
    """Without a trace, with the exit code of one that was asked to end."""
    command = ['ros2', 'run', 'blob_tracker', name]
    with probe(domain) as node, Process(command, domain) as process:
        node.spin_until(lambda: name in node.get_node_names())
        assert process.ctrl_c() == 0
    assert 'Traceback' not in process.output
    assert 'Failed to publish' not in process.output


def test_echo_shows_a_bearing(domain: int, ros2) -> None:
    """In the optical frame, as YAML."""
    with (
        probe(domain) as node, start('simulator', domain), start('segmenter', domain),
        start('locator', domain),
    ):
        bearings = node.record(Vector3Stamped, 'target/bearing')
        node.spin_until(lambda: bearings)
        said = ros2(
            'topic', 'echo', '/target/bearing', 'geometry_msgs/msg/Vector3Stamped', '--once'
        )
    bearing = next(yaml.safe_load_all(said))
    assert bearing['header']['frame_id'] == bearings[0].header.frame_id
    assert set(bearing['vector']) == {'x', 'y', 'z'}


def test_parameters_are_dumped_and_loaded(domain: int, ros2, tmp_path: Path) -> None:
    """All of a node; what is loaded is what it has then."""
    with probe(domain) as node, start('locator', domain):
        node.spin_until(lambda: 'locator' in node.get_node_names())
        dumped = yaml.safe_load(ros2('param', 'dump', '/locator', *DIRECT))
        values = dumped['/locator']['ros__parameters']
        assert values['method'] == 'maximum_likelihood'
        values['method'] = 'centroid'
        path = tmp_path / 'locator.yaml'
        path.write_text(yaml.safe_dump({
            '/locator': {'ros__parameters': {'method': values['method']}}
        }))
        ros2('param', 'load', '/locator', str(path), *DIRECT)
        assert 'centroid' in ros2('param', 'get', '/locator', 'method', *DIRECT)


def test_a_dump_can_be_loaded_whole_at_the_start(domain: int, ros2, tmp_path: Path) -> None:
    """Numbers and empty lists come back with their types."""
    path = tmp_path / 'segmenter.yaml'
    with probe(domain) as node, start('segmenter', domain):
        node.spin_until(lambda: 'segmenter' in node.get_node_names())
        path.write_text(ros2('param', 'dump', '/segmenter', *DIRECT))
    with probe(domain) as node, start(
        'segmenter', domain, '--params-file', str(path)
    ) as process:
        node.spin_until(lambda: 'segmenter' in node.get_node_names())
        assert process.end() == 0, process.output


def test_a_service_is_called(domain: int, ros2) -> None:
    """With the sentence of a camera that is not there."""
    with probe(domain) as node, start('camera', domain, device='/dev/no_such_camera'):
        node.spin_until(lambda: 'camera' in node.get_node_names())
        said = ros2('service', 'call', '/camera/find_exposure', 'std_srvs/srv/Trigger')
    assert 'success=False' in said

"""The launch files end to end, as `ros2 launch` starts them."""

from __future__ import annotations

from pathlib import Path
import sys

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
import pytest
from support.bags import of_best_effort
from support.clients import needs
from support.processes import probe, Process

needs('launch', 'launch_ros')

ROOT = Path(__file__).parents[2]
BAG = ROOT / 'test' / 'bags' / 'flash_mcap'
LOCATED = 28  # bearings that this bag gives: see test/commands/test_replay.py
# What `ros2 launch FILE name:=value` does.
LAUNCH = """
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
import sys
service = LaunchService()
service.include_launch_description(LaunchDescription([IncludeLaunchDescription(
    PythonLaunchDescriptionSource(sys.argv[1]),
    launch_arguments=[argument.split(':=', 1) for argument in sys.argv[2:]],
)]))
sys.exit(service.run())
"""


@pytest.mark.parametrize('pipeline', ['false', 'true'])
def test_tracker_tracks_a_simulated_light(pipeline: str, domain: int) -> None:
    """Bearings in the namespace, and a Ctrl-C ends all."""
    command = [
        sys.executable, '-c', LAUNCH, str(ROOT / 'launch' / 'tracker.launch.py'),
        'simulate:=true', f'pipeline:={pipeline}', 'namespace:=boat',
    ]
    with probe(domain) as node:
        bearings = node.record(Vector3Stamped, '/boat/target/bearing')
        with Process(command, domain) as launch:
            node.spin_until(lambda: len(bearings) >= 10, timeout=60.0)
            assert launch.end(timeout=20.0) == 0, launch.output
    assert 'process has died' not in launch.output


@pytest.mark.parametrize('pipeline', ['false', 'true'])
@pytest.mark.parametrize('reliability', ['reliable', 'best_effort'])
def test_replay_locates_all_of_a_bag_and_ends(
    reliability: str, pipeline: str, domain: int, tmp_path: Path
) -> None:
    """Every bearing of the bag, whatever its driver offered, then the launch ends by itself."""
    bag = BAG if reliability == 'reliable' else of_best_effort(tmp_path / 'bag')
    command = [
        sys.executable, '-c', LAUNCH, str(ROOT / 'launch' / 'replay.launch.py'),
        f'bag:={bag}', 'rate:=10', f'pipeline:={pipeline}',
    ]
    with probe(domain) as node:
        # The locator's own count: the bag can be over before a busy machine has told us of it.
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with Process(command, domain) as launch:
            node.spin_until(lambda: not launch.running, timeout=90.0)
            assert launch.wait() == 0, launch.output
    counts = [
        int(value.value) for message in diagnostics for status in message.status
        for value in status.values if value.key == 'bearings'
    ]
    assert max(counts) == LOCATED, launch.output

"""The launch files on a stand-in; for real in test/clients/test_launch.py."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from blob_tracker.commands import replay
import pytest
from support import stand_in_launch
from support.processes import executable
from support.stand_in_launch import ExecuteProcess, LaunchContext, Node, RegisterEventHandler

ROOT = Path(__file__).parents[1]
CONFIG = '/share/blob_tracker/config'
Start = Callable[..., list[Any]]


@pytest.fixture
def context() -> LaunchContext:
    """Give the stand-in's context, to look into after a launch."""
    return LaunchContext()


@pytest.fixture
def start(monkeypatch: pytest.MonkeyPatch, context: LaunchContext) -> Start:
    """Give a function that says what a launch file starts."""
    def start(name: str, **arguments: str) -> list[Any]:
        path = ROOT / 'launch' / f'{name}.launch.py'
        return stand_in_launch.started(path, monkeypatch, context, **arguments)

    return start


def parameters(node: Node, context: LaunchContext) -> tuple[list[str], dict[str, Any]]:
    """Return the parameter files of a node and what is given besides."""
    files = [stand_in_launch.text(p, context) for p in node.parameters if not isinstance(p, dict)]
    given = {k: v for p in node.parameters if isinstance(p, dict) for k, v in p.items()}
    return files, given


@pytest.mark.parametrize(
    'arguments, executables, given',
    [
        ({}, ['camera', 'segmenter', 'locator', 'tracker'], {}),
        ({'simulate': 'true'}, ['simulator', 'segmenter', 'locator', 'tracker'], {}),
        ({'pipeline': 'true'}, ['pipeline'], {}),
        ({'pipeline': 'true', 'simulate': 'true'}, ['pipeline'], {'source': 'simulator'}),
        (
            {'device': '/dev/video2', 'camera_info_url': 'lens.yaml'},
            ['camera', 'segmenter', 'locator', 'tracker'],
            {'device': '/dev/video2', 'camera_info_url': 'lens.yaml'},
        ),
        ({'pipeline': 'true', 'device': '/dev/video2'}, ['pipeline'], {'device': '/dev/video2'}),
        ({'use_sim_time': 'true', 'pipeline': 'true'}, ['pipeline'], {'use_sim_time': True}),
        (
            {'body_url': 'drone.yaml'},
            ['camera', 'segmenter', 'locator', 'tracker', 'constellation'], {},
        ),
        (
            {'body_url': 'drone.yaml', 'pipeline': 'true', 'simulate': 'true'},
            ['pipeline', 'constellation'], {'source': 'simulator', 'body_url': 'drone.yaml'},
        ),
    ],
)
def test_tracker_starts_what_the_arguments_say(
    arguments: dict[str, str],
    executables: list[str],
    given: dict[str, Any],
    start: Start,
    context: LaunchContext,
) -> None:
    """The nodes are ours, and nothing overrides the parameter file but what was given."""
    nodes = start('tracker', **arguments)
    assert [node.executable for node in nodes] == executables
    for node in nodes:
        assert node.package == 'blob_tracker'
        assert executable(node.executable).exists()
        assert parameters(node, context)[0] == [f'{CONFIG}/tracker.yaml']
    assert parameters(nodes[0], context)[1] == given


def test_the_constellation_gets_the_body(start: Start, context: LaunchContext) -> None:
    """Beside the parameter file, in which its other parameters are."""
    *_, node = start('tracker', body_url='drone.yaml', namespace='boat')
    assert parameters(node, context) == (
        [f'{CONFIG}/tracker.yaml'], {'body_url': 'drone.yaml'})
    assert node.namespace == 'boat'


def test_every_tracker_node_gets_namespace_file_and_log_level(
    start: Start, context: LaunchContext
) -> None:
    """So does RViz, whose topics are relative."""
    nodes = start(
        'tracker', namespace='boat', params_file='mine.yaml', log_level='debug', rviz='true'
    )
    rviz, *trackers = nodes
    assert len(trackers) == 4
    for node in trackers:
        assert node.namespace == 'boat'
        assert node.ros_arguments == ['--log-level', 'debug']
        assert parameters(node, context)[0] == ['mine.yaml']
    assert (rviz.package, rviz.executable, rviz.namespace) == ('rviz2', 'rviz2', 'boat')
    flag, view = rviz.arguments
    assert (flag, view.perform(context)) == ('-d', f'{CONFIG}/blob_tracker.rviz')
    assert (ROOT / 'config' / 'blob_tracker.rviz').exists()


@pytest.mark.parametrize(('arguments', 'given'), [
    ({}, {}),
    ({'light': 'red', 'use_sim_time': 'true'}, {'light': 'red', 'use_sim_time': True}),
])
def test_triangulator_takes_the_rig(
    arguments: dict[str, str], given: dict[str, Any], start: Start, context: LaunchContext
) -> None:
    """Nothing overrides the parameter file but what was given."""
    node, = start('triangulator', params_file='rig.yaml', log_level='debug', **arguments)
    assert (node.package, node.executable) == ('blob_tracker', 'triangulator')
    assert executable(node.executable).exists()
    assert parameters(node, context) == (['rig.yaml'], given)
    assert node.ros_arguments == ['--log-level', 'debug']


@pytest.mark.parametrize('name', ['tracker', 'replay'])
def test_fast_dds_gets_its_profile_unless_one_is_set(
    name: str, start: Start, context: LaunchContext
) -> None:
    """Who has a profile keeps it."""
    arguments = {'bag': 'BAG'} if name == 'replay' else {}
    start(name, **arguments)
    assert context.environment == {'FASTRTPS_DEFAULT_PROFILES_FILE': f'{CONFIG}/fastdds.xml'}
    context.environment['FASTRTPS_DEFAULT_PROFILES_FILE'] = 'mine.xml'
    start(name, **arguments)
    assert context.environment == {'FASTRTPS_DEFAULT_PROFILES_FILE': 'mine.xml'}


@pytest.mark.parametrize(
    'pipeline, executables',
    [('false', ['segmenter', 'locator', 'tracker']), ('true', ['pipeline'])],
)
def test_replay_plays_the_bag_into_the_nodes(
    pipeline: str, executables: list[str], start: Start, context: LaunchContext
) -> None:
    """No frame is lost, time is the bag's, and what is played is what the nodes take."""
    *nodes, player, _ = start('replay', bag='BAG', rate='4', pipeline=pipeline)
    assert [node.executable for node in nodes] == executables
    for node in nodes:
        files, given = parameters(node, context)
        assert files == [f'{CONFIG}/tracker.yaml', f'{CONFIG}/replay.yaml']
        assert given == {'use_sim_time': True} | (
            {'source': 'images'} if pipeline == 'true' else {}
        )
    assert isinstance(player, ExecuteProcess)
    assert player.cmd[:5] == ['python3', '-m', 'blob_tracker', 'replay', 'BAG']
    # The player itself says whether it takes them.
    parser = argparse.ArgumentParser()
    replay.add_arguments(parser)
    options = parser.parse_args(player.cmd[4:])
    assert (options.rate, options.clock) == (4.0, True)
    assert options.nodes == ['segmenter', 'locator', 'tracker']
    assert options.topics == ['/camera/image_raw', '/camera/camera_info']
    assert options.remap == []


@pytest.mark.parametrize('pipeline', ['false', 'true'])
def test_replay_takes_the_compressed_images(
    pipeline: str, start: Start, context: LaunchContext
) -> None:
    """The node that takes images is told so, and their topic is played; else as the file says."""
    taker, *_, player, _ = start(
        'replay', bag='BAG', image_transport='compressed', pipeline=pipeline)
    assert parameters(taker, context)[1]['image_transport'] == 'compressed'
    parser = argparse.ArgumentParser()
    replay.add_arguments(parser)
    options = parser.parse_args(player.cmd[4:])
    assert '/camera/image_raw/compressed' in options.topics
    taker, *_ = start('replay', bag='BAG', pipeline=pipeline)
    assert 'image_transport' not in parameters(taker, context)[1]


def test_replay_renames_topics_of_the_bag(start: Start) -> None:
    """As the player's own option does."""
    *_, player, _ = start('replay', bag='BAG', remap='/left/image_raw:=/camera/image_raw')
    parser = argparse.ArgumentParser()
    replay.add_arguments(parser)
    options = parser.parse_args(player.cmd[4:])
    assert options.remap == [('/left/image_raw', '/camera/image_raw')]


def test_replay_ends_with_the_bag(start: Start, context: LaunchContext) -> None:
    """At once where there is none, and with a pause for the last frames where it was played."""
    *_, player, handler = start('replay', bag='BAG', finish='3.5')
    assert isinstance(handler, RegisterEventHandler)
    assert handler.event_handler.target_action is player
    end = handler.event_handler.on_exit
    assert end(stand_in_launch.ProcessExited(1), context) == stand_in_launch.Shutdown()
    last = end(stand_in_launch.ProcessExited(0), context)
    assert (last.period, last.actions) == (3.5, [stand_in_launch.Shutdown()])

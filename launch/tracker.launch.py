"""
Camera (or simulator), segmenter, locator and tracker: a process each, or pipeline:=true.

With body_url the constellation as well, which takes the rays of the body's lights.
"""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import (
    EnvironmentVariable,
    LaunchConfiguration,
    PathJoinSubstitution,
)
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

CONFIG = [FindPackageShare('blob_tracker'), 'config']
SWITCH = ['true', 'false']
PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE'


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and what they start."""
    return LaunchDescription([
        DeclareLaunchArgument(
            'pipeline', default_value='false', choices=SWITCH,
            description='all nodes in one process: frames are handed over in memory',
        ),
        DeclareLaunchArgument(
            'simulate', default_value='false', choices=SWITCH,
            description='a simulated camera in place of the real one',
        ),
        DeclareLaunchArgument(
            'device', default_value='',
            description='the camera, as /dev/video0; empty leaves it to params_file',
        ),
        DeclareLaunchArgument(
            'camera_info_url', default_value='',
            description='its calibration, path or URL; empty leaves it to params_file',
        ),
        DeclareLaunchArgument(
            'body_url', default_value='',
            description='where the lights are on a body, path or URL: its pose is published',
        ),
        DeclareLaunchArgument('namespace', default_value='', description='of all nodes'),
        DeclareLaunchArgument(
            'params_file', default_value=PathJoinSubstitution([*CONFIG, 'tracker.yaml']),
            description='parameters of the nodes',
        ),
        DeclareLaunchArgument(
            'use_sim_time', default_value='false', choices=SWITCH,
            description='time from /clock',
        ),
        DeclareLaunchArgument(
            'log_level', default_value='info',
            choices=['debug', 'info', 'warn', 'error', 'fatal'],
            description='least severity that is logged',
        ),
        DeclareLaunchArgument(
            'rviz', default_value='false', choices=SWITCH,
            description='RViz with frame, window and ray as well',
        ),
        # Without it Fast DDS loses large images: see the file. A profile already set stays.
        SetEnvironmentVariable(PROFILES, EnvironmentVariable(
            PROFILES, default_value=PathJoinSubstitution([*CONFIG, 'fastdds.xml']),
        )),
        OpaqueFunction(function=_nodes),
    ])


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the processes; called with the arguments known."""
    def argument(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    # What is not given must not override the parameter file.
    camera = {name: argument(name) for name in ('device', 'camera_info_url') if argument(name)}
    body = {'body_url': argument('body_url')} if argument('body_url') else {}
    clock = {'use_sim_time': True} if argument('use_sim_time') == 'true' else {}
    simulate = argument('simulate') == 'true'

    def node(executable: str, **parameters: str) -> Node:
        return Node(
            package='blob_tracker',
            executable=executable,
            namespace=argument('namespace'),
            parameters=[argument('params_file'), {**clock, **parameters}],
            ros_arguments=['--log-level', argument('log_level')],
            output='screen',
        )

    if argument('pipeline') == 'true':
        # No name: it would be that of each node in the process.
        nodes = [node('pipeline', **({'source': 'simulator', **body} if simulate else camera))]
    else:
        source = node('simulator', **body) if simulate else node('camera', **camera)
        nodes = [source, node('segmenter'), node('locator'), node('tracker')]
    if body:
        nodes.append(node('constellation', **body))
    if argument('rviz') == 'true':
        view = PathJoinSubstitution([*CONFIG, 'blob_tracker.rviz'])
        # First: if there is no RViz, launch stops here, and leaves no node behind.
        nodes.insert(0, Node(
            package='rviz2',
            executable='rviz2',
            namespace=argument('namespace'),  # the topics in the file are relative
            arguments=['-d', view],
            parameters=[clock],
        ))
    return nodes

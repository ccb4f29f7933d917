"""Positions of a light by the rays of several cameras, whose trackers run in their namespaces."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SWITCH = ['true', 'false']


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and what they start."""
    return LaunchDescription([
        DeclareLaunchArgument(
            'params_file', description='where the cameras are: rig.yaml of `calibrate rig`',
        ),
        DeclareLaunchArgument(
            'light', default_value='', description='its name; empty is that of params_file',
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
        OpaqueFunction(function=_nodes),
    ])


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the process; called with the arguments known."""
    def argument(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    # What is not given must not override the parameter file.
    light = {'light': argument('light')} if argument('light') else {}
    clock = {'use_sim_time': True} if argument('use_sim_time') == 'true' else {}
    return [Node(
        package='blob_tracker',
        executable='triangulator',
        parameters=[argument('params_file'), {**clock, **light}],
        ros_arguments=['--log-level', argument('log_level')],
        output='screen',
    )]

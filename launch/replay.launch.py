"""A bag through segmenter, locator and tracker, in the bag's time; ends when the bag does."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    Shutdown,
    TimerAction,
)
from launch.event_handlers import OnProcessExit
from launch.events.process import ProcessExited
from launch.substitutions import (
    EnvironmentVariable,
    LaunchConfiguration,
    PathJoinSubstitution,
)
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

CONFIG = [FindPackageShare('blob_tracker'), 'config']
PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE'
STARTUP = '60'  # s that the nodes may take: the first start compiles the fits


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and what they start."""
    return LaunchDescription([
        DeclareLaunchArgument('bag', description='the bag: its folder, or a file of it'),
        DeclareLaunchArgument(
            'rate', default_value='1.0', description='speed: 2 is twice as fast as recorded'
        ),
        DeclareLaunchArgument(
            'topics', default_value='/camera/image_raw /camera/camera_info',
            description='topics of the bag; recorded results would mix with the new ones',
        ),
        DeclareLaunchArgument(
            'remap', default_value='', description='FROM:=TO for topics of the bag'
        ),
        DeclareLaunchArgument(
            'image_transport', default_value='', choices=['', 'raw', 'compressed'],
            description='which images of the bag are used: Image or CompressedImage; if left '
            'empty, what params_file says',
        ),
        DeclareLaunchArgument(
            'pipeline', default_value='false', choices=['true', 'false'],
            description='segmenter, locator and tracker in one process',
        ),
        DeclareLaunchArgument(
            'params_file', default_value=PathJoinSubstitution([*CONFIG, 'tracker.yaml']),
            description='parameters of the nodes',
        ),
        DeclareLaunchArgument(
            'finish', default_value='2.0',
            description='seconds for the nodes to work off what was played faster than they work',
        ),
        SetEnvironmentVariable(PROFILES, EnvironmentVariable(
            PROFILES, default_value=PathJoinSubstitution([*CONFIG, 'fastdds.xml']),
        )),
        OpaqueFunction(function=_nodes),
    ])


def _nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the processes; called with the arguments known."""
    def argument(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    def node(executable: str, **parameters: str) -> Node:
        return Node(
            package='blob_tracker',
            executable=executable,
            parameters=[
                argument('params_file'),
                PathJoinSubstitution([*CONFIG, 'replay.yaml']),
                {'use_sim_time': True, **parameters},
            ],
            output='screen',
        )

    topics = argument('topics').split()
    transport = {}
    if chosen := argument('image_transport'):
        transport = {'image_transport': chosen}
    if chosen == 'compressed':
        topics.append('/camera/image_raw/compressed')
    if argument('pipeline') == 'true':
        nodes = [node('pipeline', source='images', **transport)]
    else:
        nodes = [node('segmenter', **transport), node('locator'), node('tracker')]
    # Not `ros2 bag play`: that begins before the nodes are there, and the first frames are lost.
    player = ExecuteProcess(
        cmd=[
            'python3', '-m', 'blob_tracker', 'replay', argument('bag'),
            '--rate', argument('rate'), '--clock', '--wait', STARTUP,
            '--nodes', 'segmenter', 'locator', 'tracker', '--topics', *topics,
            *(['--remap', *remap] if (remap := argument('remap').split()) else []),
        ],
        output='screen',
    )

    def end(event: ProcessExited, context: LaunchContext) -> LaunchDescriptionEntity:
        if event.returncode:  # it said why
            return Shutdown()
        return TimerAction(period=float(argument('finish')), actions=[Shutdown()])

    return [*nodes, player, RegisterEventHandler(OnProcessExit(target_action=player, on_exit=end))]

"""Camera (or simulator), segmenter and locator, as three processes."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the nodes and the arguments that choose camera, calibration and namespace."""
    share = FindPackageShare('blob_tracker')
    arguments = [
        DeclareLaunchArgument('device', default_value='/dev/video0', description='the camera'),
        DeclareLaunchArgument(
            'camera_info_url', default_value='', description='its calibration: path or URL'
        ),
        DeclareLaunchArgument(
            'simulate', default_value='false', description='a simulated camera in its place'
        ),
        DeclareLaunchArgument('namespace', default_value='', description='of all nodes'),
        DeclareLaunchArgument(
            'params_file',
            default_value=PathJoinSubstitution([share, 'config', 'tracker.yaml']),
            description='parameters of the nodes',
        ),
        # Without it Fast DDS loses every fifth image: see the file.
        SetEnvironmentVariable(
            'FASTRTPS_DEFAULT_PROFILES_FILE',
            PathJoinSubstitution([share, 'config', 'fastdds.xml']),
        ),
    ]
    simulate = LaunchConfiguration('simulate')
    common = {
        'package': 'blob_tracker',
        'namespace': LaunchConfiguration('namespace'),
        'output': 'screen',
    }
    params_file = LaunchConfiguration('params_file')
    camera = Node(
        executable='camera',
        parameters=[
            params_file,
            {
                'device': LaunchConfiguration('device'),
                'camera_info_url': LaunchConfiguration('camera_info_url'),
            },
        ],
        condition=UnlessCondition(simulate),
        **common,
    )
    simulator = Node(executable='simulator', condition=IfCondition(simulate), **common)
    trackers = [
        Node(executable=name, parameters=[params_file], **common)
        for name in ('segmenter', 'locator')
    ]
    return LaunchDescription([*arguments, camera, simulator, *trackers])

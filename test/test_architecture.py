"""The rules of the house that a machine can check."""

from __future__ import annotations

import ast
from pathlib import Path

import blob_tracker

ROOT = Path(blob_tracker.__file__).parent
ROS_FOLDERS = ('ros', 'nodes', 'commands')
ROS_MODULES = {
    'ament_index_python',
    'builtin_interfaces',
    'diagnostic_msgs',
    'geometry_msgs',
    'nav_msgs',
    'rcl_interfaces',
    'rclpy',
    'rosgraph_msgs',
    'sensor_msgs',
    'std_msgs',
    'std_srvs',
}
# Each room may import the rooms named here, besides itself, types and units.
ROOMS = {
    'types': set(),
    'units': set(),
    'resources': set(),
    'drawing': set(),
    'colour': set(),
    'capture': {'colour', 'drawing'},
    'kernel': set(),
    'segmentation': {'colour', 'drawing', 'kernel'},
    'location': {'drawing', 'kernel'},
    'camera': set(),
    'tracking': {'kernel'},
    'calibration': {'segmentation', 'location', 'camera'},
    'pipeline': {'capture', 'segmentation', 'location', 'camera', 'tracking'},
    'simulation': {'capture', 'segmentation', 'location', 'camera', 'tracking', 'pipeline'},
    'studies': {
        'capture', 'segmentation', 'location', 'camera', 'tracking', 'calibration', 'pipeline',
        'simulation',
    },
    'ros': {
        'capture', 'colour', 'segmentation', 'location', 'camera', 'tracking', 'calibration',
        'pipeline',
        'resources',
    },
    'nodes': {
        'capture', 'colour', 'segmentation', 'location', 'camera', 'tracking', 'calibration',
        'pipeline',
        'simulation', 'ros', 'resources', 'kernel',
    },
    'commands': {
        'capture', 'colour', 'segmentation', 'location', 'camera', 'tracking', 'calibration',
        'pipeline',
        'simulation', 'studies', 'ros', 'nodes', 'resources', 'kernel',
    },
    '__main__': {'commands'},
    '__init__': {'camera', 'pipeline'},
}


def imports(path: Path) -> set[str]:
    """Return the full names of what a file imports."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: write the full name of {node.module}'
            names.add(str(node.module))
    return names


def sources() -> list[tuple[str, Path]]:
    """Return each source file with the room that it belongs to."""
    paths = sorted(ROOT.rglob('*.py'))
    assert len(paths) > 30
    return [(path.relative_to(ROOT).parts[0].removesuffix('.py'), path) for path in paths]


def test_only_ros_and_nodes_know_ros() -> None:
    """The core works where no ROS is installed."""
    for room, path in sources():
        if room not in ROS_FOLDERS:
            ros = {name for name in imports(path) if name.split('.')[0] in ROS_MODULES}
            assert not ros, f'{path} imports {ros}'


def test_arrows_point_down() -> None:
    """A room imports itself, types, units, and the rooms below it."""
    for room, path in sources():
        for name in imports(path):
            package, _, inside = name.partition('.')
            if package == 'blob_tracker' and inside:
                target = inside.split('.')[0]
                assert target in ROOMS[room] | {room, 'types', 'units'}, f'{path} imports {name}'

"""The rules of the house that a machine can check."""

from __future__ import annotations

import ast
from pathlib import Path
import re

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
# A row of the table of rooms: the room, what is in it, what it may import.
ROW = re.compile(r'^\| `([^`]+)` \| (.+) \| ([^|`]+) \|$', re.M)
ROWS = ROW.findall((Path(__file__).parents[1] / 'CONTRIBUTING.md').read_text())


def rooms(rows: list[tuple[str, str, str]]) -> dict[str, set[str]]:
    """Return what each room may import, besides itself and types."""
    found: dict[str, set[str]] = {}
    for place, _, allowed in rows:
        names = allowed.removeprefix('all above').removeprefix(' but ')
        named = set() if names in ('', '-') else set(names.split(', '))
        assert named <= found.keys(), f'{place} may import {allowed}: not all of it is above'
        found[place.rstrip('/').removesuffix('.py')] = (
            found.keys() - named if allowed.startswith('all above') else named
        )
    return found


ROOMS = rooms(ROWS)


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


def test_the_table_of_rooms_is_whole() -> None:
    """Each room has a row, and what a row names is in its room."""
    assert ROOMS.keys() == {room for room, _ in sources()}
    for place, described, _ in ROWS:
        for name in re.findall(r'`([\w/]+(?:/|\.py))`', described):
            assert (ROOT / place / name).exists(), f'{place} has no {name}'


def test_only_ros_and_nodes_know_ros() -> None:
    """The core works where no ROS is installed."""
    for room, path in sources():
        if room not in ROS_FOLDERS:
            ros = {name for name in imports(path) if name.split('.')[0] in ROS_MODULES}
            assert not ros, f'{path} imports {ros}'


def test_arrows_point_down() -> None:
    """A room imports itself, types, and the rooms below it."""
    for room, path in sources():
        for name in imports(path):
            package, _, inside = name.partition('.')
            if package == 'blob_tracker' and inside:
                target = inside.split('.')[0]
                assert target in ROOMS[room] | {room, 'types'}, f'{path} imports {name}'

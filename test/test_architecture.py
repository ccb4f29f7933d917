"""The rules of the house that a machine can check."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
import re

import blob_tracker

ROOT = Path(blob_tracker.__file__).parent
LONGEST_FUNCTION = 100  # lines without its docstring: what is longer is two things
BENCHMARKS = sorted((Path(__file__).parents[1] / 'benchmarks').rglob('*.py'))
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
    'tf2_msgs',
}
# A row of the table of rooms: the room, what is in it, what it may import.
ROW = re.compile(r'^\| `([^`]+)` \| (.+) \| ([^|`]+) \|$', re.M)
ROWS = ROW.findall((Path(__file__).parents[1] / 'CONTRIBUTING.md').read_text())


def rooms(rows: list[tuple[str, str, str]]) -> dict[str, set[str]]:
    """Return what each room may import, besides itself, types and units."""
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
    """A room imports itself, types, units, and the rooms below it."""
    for room, path in sources():
        for name in imports(path):
            package, _, inside = name.partition('.')
            if package == 'blob_tracker' and inside:
                target = inside.split('.')[0]
                assert target in ROOMS[room] | {room, 'types', 'units'}, f'{path} imports {name}'


def test_no_function_is_too_long() -> None:
    """What a function does is seen at one look, or has a name of its own for each part."""
    for path in [path for _, path in sources()] + BENCHMARKS:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                lines = int(node.end_lineno or 0) - node.lineno + 1
                if ast.get_docstring(node) is not None:
                    lines -= int(node.body[0].end_lineno or 0) - node.body[0].lineno + 1
                assert lines <= LONGEST_FUNCTION, f'{path}: {node.name} has {lines} lines'


def test_no_two_files_import_each_other() -> None:
    """Not by a detour either, nor for the sake of annotations alone."""
    files = {
        '.'.join(path.relative_to(ROOT.parent).with_suffix('').parts).removesuffix('.__init__'):
        path for _, path in sources()
    }
    below = {name: set(within(path, files)) - {name} for name, path in files.items()}
    # What imports nothing that is left is taken away; of a circle none ever is.
    while free := {name for name, others in below.items() if not others & below.keys()}:
        below = {name: others for name, others in below.items() if name not in free}
    circles = [name for name in below if reaches(below, name, name)]
    assert not circles, f'these import each other: {circles}'


def within(path: Path, files: dict[str, Path]) -> Iterator[str]:
    """
    Yield the modules of the package that a file imports at its top level.

    A name that is imported from a package is the module of that name, where there is one.
    """
    tree = ast.parse(path.read_text())
    guarded = (each for node in tree.body if isinstance(node, ast.If) for each in node.body)
    for node in (*tree.body, *guarded):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in files)
        elif isinstance(node, ast.ImportFrom) and node.module in files:
            for alias in node.names:
                module = f'{node.module}.{alias.name}'
                yield module if module in files else str(node.module)


def reaches(below: dict[str, set[str]], start: str, end: str) -> bool:
    """Tell whether a way of imports leads from one module to another."""
    seen: set[str] = set()
    ahead = {start}
    while ahead:
        seen |= ahead
        ahead = {other for name in ahead for other in below[name] if other in below}
        if end in ahead:
            return True
        ahead -= seen
    return False

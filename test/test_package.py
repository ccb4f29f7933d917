"""What ROS sees of the package once colcon has built it."""

from __future__ import annotations

import ast
import os
from pathlib import Path
import subprocess
import sys

from ament_index_python.packages import get_package_share_directory, get_packages_with_prefixes
import blob_tracker
from blob_tracker.nodes import NODES
from catkin_pkg.package import parse_package
from support.processes import executable
import yaml

ROOT = Path(__file__).parents[1]
# Keys of rosdistro (rosdep/python.yaml and jazzy/distribution.yaml) with what they install on
# Ubuntu 24.04; looked up by hand when a key is added.
KNOWN_KEYS = yaml.safe_load((Path(__file__).parent / 'rosdep_keys.yaml').read_text())
# What the package imports, by the key that installs it.
KEYS = {
    # rosbags brings apsw, zstd and lz4.
    **dict.fromkeys(('apsw', 'backports', 'lz4', 'rosbags'), 'python3-rosbags-pip'),
    'cv2': 'python3-opencv',
    'matplotlib': 'python3-matplotlib',
    'numba': 'python3-numba',
    'numpy': 'python3-numpy',
    'rich': 'python3-rich',
    'scipy': 'python3-scipy',
    'yaml': 'python3-yaml',
}
# What is imported only where it is asked for, by the extra of setup.py that brings it: rosdep has
# no key for these.
EXTRAS = {'distributed': 'cluster'}


def test_package_xml_is_format_3_with_keys_that_exist() -> None:
    """It parses without a warning, and rosdep knows each key for Jazzy."""
    warnings: list[str] = []
    package = parse_package(str(ROOT), warnings=warnings)
    assert not warnings
    assert package.package_format == 3
    assert package.get_build_type() == 'ament_python'
    assert [str(text) for text in package.licenses] == ['Apache-2.0']
    keys = {d.name for d in package.build_depends + package.exec_depends + package.test_depends}
    assert keys <= set(KNOWN_KEYS)


def test_every_import_is_declared() -> None:
    """What the package imports is in package.xml, to be installed wherever it runs."""
    package = parse_package(str(ROOT))
    declared = {d.name for d in package.exec_depends}
    used = set()
    for path in Path(blob_tracker.__file__).parent.rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                used |= {alias.name.split('.')[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                used.add(str(node.module).split('.')[0])
    foreign = used - set(sys.stdlib_module_names) - {'blob_tracker'} - set(EXTRAS)
    assert {KEYS.get(name, name) for name in foreign} <= declared
    setup = (ROOT / 'setup.py').read_text()
    assert all(f"'{extra}': ['{name}']" in setup for name, extra in EXTRAS.items())


def test_colcon_sees_an_ament_python_package() -> None:
    """A package.xml with a fault would silently become plain Python."""
    result = subprocess.run(
        ['colcon', '--log-base', os.devnull, 'list', '--paths', str(ROOT)],
        capture_output=True,
        text=True,
    )
    assert '(ros.ament_python)' in result.stdout, result.stdout + result.stderr


def test_installed_files_are_where_ros_looks() -> None:
    """Executables in lib/blob_tracker, the ament index entry, config and launch in share."""
    for name in NODES:
        assert os.access(executable(name), os.X_OK)
    assert 'blob_tracker' in get_packages_with_prefixes()
    share = Path(get_package_share_directory('blob_tracker'))
    for name in (
        'package.xml',
        'config/tracker.yaml',
        'config/blob_tracker.rviz',
        'examples/servo_client.py',
        'launch/tracker.launch.py',
    ):
        assert (share / name).is_file()

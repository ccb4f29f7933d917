"""Python, ROS, the middleware, the package and its kernels, each made wrong for the doctor."""

from __future__ import annotations

import os
from pathlib import Path
import sys

from blob_tracker.commands.doctor import checks, compiled, installation, python
from blob_tracker.commands.doctor.finding import Level, ok
from blob_tracker.nodes import NODES
import pytest
from support.findings import one, told


# Python and the libraries


def test_python_that_the_wheels_are_not_made_for() -> None:
    """3.10 to 3.13."""
    told(python.check_python((3, 9)), Level.ERROR, '3.9', 'runs on 3.10 to 3.13')
    told(python.check_python((3, 14)), Level.ERROR, '3.14')
    told(python.check_python((3, 10)), Level.OK, '3.10')


def test_libraries_that_are_missing_or_broken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that is required is an error; a broken one says why."""
    (tmp_path / 'broken_library.py').write_text("raise ImportError('numpy 9 is too new')")
    monkeypatch.syspath_prepend(tmp_path)
    told(python.check_libraries({'no_such_library': ('no-such', 'python3-no-such')}, {}),
         Level.ERROR, 'no_such_library is not installed', 'install ')
    told(python.check_libraries({'broken_library': ('broken', 'python3-broken')}, {}),
         Level.ERROR, 'cannot be imported: ImportError: numpy 9 is too new')
    told(python.check_libraries({}, {'no_such_library': ('no-such', '', 'bags')}),
         Level.WARN, 'bags need it', 'pip install no-such')
    told(python.check_libraries(), Level.OK, 'numpy ', 'opencv-python-headless ', 'rosbags ')


# ROS


def fake_rclpy(prefix: Path, source: str) -> Path:
    """Make a package rclpy where apt would have put it."""
    package = prefix / 'lib' / 'python3.12' / 'site-packages' / 'rclpy'
    package.mkdir(parents=True)
    (package / '__init__.py').write_text(source)
    (package / 'node.py').touch()
    return package / '__init__.py'


def test_no_ros_at_all(tmp_path: Path) -> None:
    """The core is said to work, and the way to ROS depends on what the machine has."""
    told(installation.check_ros({}, None, [], tmp_path), Level.ERROR,
         'no node can run', 'Pipeline', 'pip install')
    (tmp_path / 'humble').mkdir()
    (tmp_path / 'humble' / 'setup.bash').touch()
    told(installation.check_ros({}, None, [], tmp_path), Level.ERROR, 'has humble')
    (tmp_path / 'jazzy').mkdir()
    (tmp_path / 'jazzy' / 'setup.bash').touch()
    told(installation.check_ros({}, None, [], tmp_path), Level.ERROR,
         f'source {tmp_path}/jazzy/setup.bash')


def test_the_wrong_ros(tmp_path: Path) -> None:
    """Another distribution, one for another Python, and two at once."""
    rclpy = fake_rclpy(tmp_path, '')
    told(installation.check_ros({'ROS_DISTRO': 'humble'}, rclpy, []), Level.ERROR,
         'ROS_DISTRO is humble', '/jazzy/setup.bash')
    told(installation.check_ros({'ROS_DISTRO': 'jazzy'}, rclpy, []), Level.OK, 'jazzy')
    rclpy.write_text("raise ImportError('built for 3.12')")
    told(installation.check_ros({'ROS_DISTRO': 'jazzy'}, rclpy, []), Level.ERROR,
         'cannot load it: ImportError: built for 3.12')


def test_the_wrong_wheels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wheel of another distribution; a wheel, and another ROS sourced."""
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))
    rclpy = fake_rclpy(tmp_path, '')
    told(installation.check_ros({}, rclpy, ['ros-kilted-rclpy']), Level.ERROR,
         'ros-kilted-rclpy is installed', 'jazzy is needed')
    told(installation.check_ros({}, rclpy, ['ros-jazzy-rclpy']), Level.OK, 'wheels')
    told(installation.check_ros({'ROS_DISTRO': 'jazzy'}, rclpy, ['ros-jazzy-rclpy']), Level.WARN,
         'there are two')


def test_middleware(tmp_path: Path) -> None:
    """The default, another one that is there, and one that is not."""
    rclpy = fake_rclpy(tmp_path, '')
    folders = installation.library_folders({'LD_LIBRARY_PATH': 'relative:/no/such'}, rclpy)
    assert folders == [tmp_path / 'lib']
    told(installation.check_rmw({}, folders), Level.ERROR, 'there is none', 'apt install')
    for name in ('rmw_fastrtps_cpp', 'rmw_fastrtps_shared_cpp', 'rmw_cyclonedds_cpp'):
        (tmp_path / 'lib' / f'lib{name}.so').touch()
    found = one(installation.check_rmw({}, folders))
    assert found == ok('RMW', 'rmw_fastrtps_cpp (installed: rmw_cyclonedds_cpp, rmw_fastrtps_cpp)')
    told(installation.check_rmw({'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}, folders),
         Level.WARN, 'export RMW_IMPLEMENTATION=rmw_fastrtps_cpp')
    told(installation.check_rmw({'RMW_IMPLEMENTATION': 'rmw_zenoh_cpp'}, folders), Level.ERROR,
         'rmw_zenoh_cpp', 'not installed', 'unset RMW_IMPLEMENTATION')


def test_messages_of_tf(tmp_path: Path) -> None:
    """There; to be installed where ROS is; and not to be had where it is not."""
    told(installation.check_tf({}, tmp_path / 'tf2_msgs' / '__init__.py'), Level.OK, 'work')
    told(installation.check_tf({'ROS_DISTRO': 'jazzy'}, None), Level.WARN,
         'sudo apt install ros-jazzy-tf2-msgs')
    told(installation.check_tf({}, None), Level.OK, 'leave use_tf and publish_tf false')


def test_package(tmp_path: Path) -> None:
    """Not installed, without executables, older than what is imported, and well."""
    imported = tmp_path / 'checkout' / 'blob_tracker'
    imported.mkdir(parents=True)
    (imported / 'types.py').write_text('new')
    told(installation.check_package({}, imported), Level.WARN, '`ros2 run`', 'colcon build')

    prefix = tmp_path / 'install'
    marker = prefix / 'share/ament_index/resource_index/packages/blob_tracker'
    marker.parent.mkdir(parents=True)
    marker.touch()
    environment = {'AMENT_PREFIX_PATH': f'/elsewhere{os.pathsep}{prefix}'}
    told(installation.check_package(environment, imported), Level.ERROR, 'has no camera, ')

    folder = prefix / 'lib' / 'blob_tracker'
    folder.mkdir(parents=True)
    for name in NODES:
        (folder / name).touch(mode=0o755)
    installed = prefix / 'lib' / 'python3.12' / 'site-packages' / 'blob_tracker'
    installed.mkdir(parents=True)
    (installed / 'types.py').write_text('old')
    told(installation.check_package(environment, imported), Level.WARN, 'imports another one')
    (installed / 'types.py').write_text('new')
    told(installation.check_package(environment, imported), Level.OK, str(prefix))


# The kernels


def test_kernels() -> None:
    """One of those that the defaults need is not compiled; and a Numba that is switched off."""
    all_needed = {name: (2, 2, '/c') for name in compiled.NEEDED}
    rooms = {'location': (3, 5, '/c'), 'segmentation': (1, 1, '/c'), 'tracking': (2, 2, '/c'),
             'constellation': (0, 4, '/c')}
    told([compiled.judge({**rooms, **all_needed}, Path('/'))], Level.OK, 'location 3 of 5')
    lacking = {**rooms, **all_needed, 'location.contract': (1, 2, '/c')}
    told([compiled.judge(lacking, Path('/my env'))], Level.WARN, 'location 3 of 5',
         'need (location.contract)', "cd '/my env' && ", sys.executable, 'compile_ahead()')
    told(compiled.check_compiled({'NUMBA_DISABLE_JIT': '1'}, Path('/')), Level.ERROR, 'unset')
    # The build compiles them ahead.
    told(compiled.check_compiled(os.environ, Path('/')), Level.OK, 'location', '__pycache__')


def test_kernels_are_those_of_the_package_that_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not those of a source tree that lies in the folder, beside an installation by pip."""
    (tmp_path / 'blob_tracker').mkdir()
    (tmp_path / 'blob_tracker' / '__init__.py').write_text("raise ImportError('the wrong one')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    check, = (check for subject, check in checks(None, self_test=False) if subject == 'kernels')
    finding, = check()
    assert 'the wrong one' not in finding.message
    assert finding.message.startswith('compiled for this processor: location ')


def test_kernels_that_cannot_be_loaded(tmp_path: Path) -> None:
    """Numba's refusal to keep its code has an advice of its own."""
    package = tmp_path / 'blob_tracker'
    package.mkdir()
    path = {**os.environ, 'PYTHONPATH': str(tmp_path)}
    (package / '__init__.py').write_text("raise RuntimeError('no locator available for file x')")
    told(compiled.check_compiled(path, tmp_path), Level.ERROR, 'export NUMBA_CACHE_DIR=')
    (package / '__init__.py').write_text("raise ImportError('no numba')")
    told(compiled.check_compiled(path, tmp_path), Level.ERROR, 'ImportError: no numba')

"""ROS, its middleware, and this package as ROS sees it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
import os
from pathlib import Path
import subprocess
import sys

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn
from blob_tracker.nodes import NODES

DISTRIBUTION = 'jazzy'
DEFAULT_RMW = 'rmw_fastrtps_cpp'
OPT = Path('/opt/ros')
SETUP = 'source {}/{}/setup.bash'
WHEELS = "pip install 'ros-jazzy-rclpy[fastrtps]' ros-jazzy-common-interfaces"
IMPORT_TIMEOUT = 30.0  # s, on a machine that is busy


def check_ros(
    environment: Mapping[str, str],
    rclpy: Path | None,
    wheels: Sequence[str],
    opt: Path = OPT,
) -> Iterator[Finding]:
    """
    Look for rclpy, and whether it is that of ROS 2 Jazzy.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    rclpy : Path or None
        Its file __init__.py where Python finds it.
    wheels : sequence of str
        Installed wheels of rclpy, as ros-jazzy-rclpy.
    opt : Path
        Where apt installs ROS.

    """
    if rclpy is None:
        yield _no_rclpy(opt)
        return
    sourced = environment.get('ROS_DISTRO', '')
    if sourced and sourced != DISTRIBUTION:
        yield error(
            'ROS',
            f'ROS_DISTRO is {sourced}; blob_tracker is for {DISTRIBUTION}',
            f'in a new terminal, without the setup of {sourced}',
            SETUP.format(opt, DISTRIBUTION),
        )
        return
    # A virtual environment may have a wheel and yet see another rclpy through PYTHONPATH.
    from_wheel = bool(wheels) and rclpy.is_relative_to(sys.prefix)
    if from_wheel and f'ros-{DISTRIBUTION}-rclpy' not in wheels:
        yield error(
            'ROS', f'{", ".join(wheels)} is installed; {DISTRIBUTION} is needed',
            'in a new virtual environment', WHEELS,
        )
        return
    failure = _import_failure(rclpy)
    if failure:
        yield error(
            'ROS',
            f'rclpy is at {rclpy.parent} and this Python cannot load it: {failure}',
            f'it is made for one version of Python, not for every; this one is {sys.executable}: '
            'use that of ROS (python3 of Ubuntu 24.04), or the wheels in their own environment',
        )
        return
    if from_wheel and sourced:
        yield warn(
            'ROS',
            f'there are two: the wheel at {rclpy.parent}, which Python takes, and {sourced} as '
            'sourced, whose libraries and nodes may not fit it',
            'start a terminal in which just one of them is set up',
        )
        return
    kind = 'wheels from PyPI' if from_wheel else f'AMENT_PREFIX_PATH of {sourced or "no setup"}'
    yield ok('ROS', f'{DISTRIBUTION}, {kind}; rclpy at {rclpy.parent}')


def _no_rclpy(opt: Path) -> Finding:
    """Say that no node can run, and which way to rclpy is the shortest here."""
    here = sorted(path.name for path in opt.glob('*') if (path / 'setup.bash').is_file())
    message = (
        'there is no rclpy for this Python: no node can run; blob_tracker as a library (Pipeline, '
        'locate, optics, calibrate from files) works'
    )
    if DISTRIBUTION in here:
        return error('ROS', message, 'set it up', SETUP.format(opt, DISTRIBUTION))
    if here:
        message += f'; {opt} has {", ".join(here)}, and {DISTRIBUTION} is needed'
    return error(
        'ROS', message, 'install ROS 2 Jazzy with apt (Ubuntu 24.04), or its wheels', WHEELS
    )


def _import_failure(rclpy: Path) -> str:
    """Return why rclpy cannot be imported, '' where it can."""
    path = os.pathsep.join([str(rclpy.parents[1]), os.environ.get('PYTHONPATH', '')])
    result = subprocess.run(
        [sys.executable, '-c', 'import rclpy, rclpy.node'],
        capture_output=True,
        text=True,
        timeout=IMPORT_TIMEOUT,
        # One that is not installed ends each process that loads rclpy; that has its own check.
        env={name: value for name, value in os.environ.items() if name != 'RMW_IMPLEMENTATION'}
        | {'PYTHONPATH': path.strip(os.pathsep)},
    )
    if result.returncode == 0:
        return ''
    lines = [line for line in result.stderr.splitlines() if 'Error' in line]
    return lines[-1] if lines else f'exit code {result.returncode}'


def library_folders(environment: Mapping[str, str], rclpy: Path | None) -> list[Path]:
    """Return the folders in which the libraries of ROS are looked for, in their order."""
    folders = [Path(part) for part in environment.get('LD_LIBRARY_PATH', '').split(os.pathsep)]
    prefixes = prefixes_of(environment)
    if rclpy is not None:  # PREFIX/lib/python3.12/site-packages/rclpy/__init__.py
        prefixes.append(rclpy.parents[4])
    for prefix in prefixes:
        folders += [prefix / 'lib', *sorted(prefix.glob('lib/*-linux-gnu'))]
    return [path for path in dict.fromkeys(folders) if path.is_absolute() and path.is_dir()]


def prefixes_of(environment: Mapping[str, str]) -> list[Path]:
    """Return where ROS looks for packages."""
    parts = environment.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [Path(part) for part in parts if part]


def check_rmw(environment: Mapping[str, str], folders: Sequence[Path]) -> Iterator[Finding]:
    """Look at which middleware the nodes will load."""
    wanted = environment.get('RMW_IMPLEMENTATION', '')
    installed = sorted({
        path.stem.removeprefix('lib')
        for folder in folders
        for path in folder.glob('librmw_*_cpp.so')
        # What two of them share, or what makes the types of their own messages, is none itself.
        if '_shared_' not in path.stem and '__' not in path.stem
    })
    have = ', '.join(installed) or 'none'
    if (wanted or DEFAULT_RMW) not in installed:
        yield error(
            'RMW',
            f'RMW_IMPLEMENTATION is {wanted or "not set"}, which means '
            f'{wanted or DEFAULT_RMW}, and it is not installed (there is {have}): no node can '
            'start',
            'take one that is there' if installed else 'install it',
            'unset RMW_IMPLEMENTATION'
            if DEFAULT_RMW in installed
            else f'sudo apt install ros-{DISTRIBUTION}-{DEFAULT_RMW.replace("_", "-")}',
        )
    elif wanted and 'fastrtps' not in wanted:
        yield warn(
            'RMW',
            f'{wanted}: it works, but what is said of rates and losses was measured on '
            f'{DEFAULT_RMW}, and config/fastdds.xml means nothing to it',
            'to have that one',
            f'export RMW_IMPLEMENTATION={DEFAULT_RMW}',
        )
    else:
        yield ok('RMW', f'{wanted or DEFAULT_RMW} (installed: {have})')


def check_tf(environment: Mapping[str, str], messages: Path | None) -> Iterator[Finding]:
    """
    Look at whether nodes can take places from TF, and publish on it.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    messages : Path or None
        File __init__.py of tf2_msgs where Python finds it.

    """
    if messages is not None:
        yield ok('TF', f'tf2_msgs at {messages.parent}: use_tf and publish_tf work')
    elif environment.get('ROS_DISTRO'):
        yield warn(
            'TF', 'tf2_msgs is not installed; with use_tf or publish_tf no node starts',
            'install it', f'sudo apt install ros-{DISTRIBUTION}-tf2-msgs',
        )
    else:
        yield ok(
            'TF',
            'there is no tf2_msgs, which is on no Python registry: leave use_tf and publish_tf '
            'false',
        )


def installed_at(environment: Mapping[str, str]) -> Path | None:
    """Return the prefix in which ROS finds this package, None if it does not."""
    marker = Path('share/ament_index/resource_index/packages/blob_tracker')
    return next((p for p in prefixes_of(environment) if (p / marker).is_file()), None)


def check_package(environment: Mapping[str, str], imported: Path) -> Iterator[Finding]:
    """
    Look at whether `ros2 run` finds the nodes, and whether they are those that Python imports.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    imported : Path
        Folder of the package that this process has imported.

    """
    prefix = installed_at(environment)
    build = 'colcon build --packages-select blob_tracker && source install/setup.bash'
    if prefix is None:
        yield warn(
            'package',
            f'it can be imported from {imported}, but is not installed where `ros2 run` and '
            '`ros2 launch` look (AMENT_PREFIX_PATH)',
            'in the workspace',
            build,
        )
        return
    folder = prefix / 'lib' / 'blob_tracker'
    missing = [name for name in NODES if not os.access(folder / name, os.X_OK)]
    if missing:
        yield error(
            'package', f'{folder} has no {", ".join(missing)} to run', 'build it again', build
        )
        return
    installed = next(prefix.glob('lib/python3*/*-packages/blob_tracker'), None)
    # Without it the package was installed with --symlink-install, and there is only one.
    if installed is not None and not installed.samefile(imported):
        if _digest(installed) != _digest(imported):
            yield warn(
                'package',
                f'`ros2 run` starts that in {prefix}, Python imports another one, of {imported}: '
                'what is tried here is not what runs there',
                'build it again, or leave that folder',
                build,
            )
            return
    yield ok('package', f'installed in {prefix}')


def _digest(package: Path) -> str:
    """Return what changes with any source file of a package."""
    digest = sha256()
    for path in sorted(package.rglob('*.py')):
        digest.update(str(path.relative_to(package)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()

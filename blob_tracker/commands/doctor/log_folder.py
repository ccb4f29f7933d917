"""The folder that nodes log to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import os
from pathlib import Path
import shutil

from blob_tracker.commands.doctor.finding import Finding, ok, warn

MIB = 2**20
LITTLE = 100 * MIB


def log_folder(environment: Mapping[str, str]) -> Path:
    """Return where nodes log: ROS_LOG_DIR, else ROS_HOME/log, else ~/.ros/log."""
    if environment.get('ROS_LOG_DIR'):
        return Path(environment['ROS_LOG_DIR']).expanduser()
    home = environment.get('ROS_HOME') or Path(environment.get('HOME', '~')) / '.ros'
    return Path(home).expanduser() / 'log'


def check_log_folder(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Look at whether it can be written to, and has room."""
    folder = log_folder(environment)
    there = next((path for path in (folder, *folder.parents) if path.exists()), Path('/'))
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK) or _is_kernel(there):
        yield warn(
            'log folder',
            f'{folder} cannot be written to ({there} is not yours): nodes run without log files',
            'name another',
            'export ROS_LOG_DIR=/tmp/ros_log',
        )
        return
    yield judge_room(folder, shutil.disk_usage(there).free)


def judge_room(folder: Path, free: int) -> Finding:
    """Return the finding on the free bytes of the folder's disk."""
    if free < LITTLE:
        return warn(
            'log folder',
            f'{folder}: {free // MIB} MiB of its disk are free; {LITTLE // MIB} are little enough',
            'make room; nodes go on without their logs on a full disk; see what these take',
            f'du -sh {folder}',
        )
    return ok('log folder', f'{folder}: {free / 2**30:.1f} GiB of its disk are free')


def _is_kernel(folder: Path) -> bool:
    """Tell whether a folder is one of the kernel's own, where even root makes no files."""
    return folder.parts[:2] in (('/', 'proc'), ('/', 'sys'))

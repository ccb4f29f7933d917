"""
What is wrong with this machine, and what to do about it.

The checks take what they look at as arguments, and load what they need when they run: the doctor
has to work where ROS, or a library, is missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import nullcontext
from functools import partial
from importlib import metadata
from importlib.util import find_spec
import os
from pathlib import Path

import blob_tracker
from blob_tracker.commands.doctor.cameras import check_cameras, check_stream
from blob_tracker.commands.doctor.compiled import check_compiled
from blob_tracker.commands.doctor.discovery import check_domain, check_multicast, check_range
from blob_tracker.commands.doctor.finding import error, Finding, Level, warn
from blob_tracker.commands.doctor.installation import (
    check_package, check_rmw, check_ros, check_tf, DEFAULT_RMW, installed_at, library_folders,
)
from blob_tracker.commands.doctor.log_folder import check_log_folder
from blob_tracker.commands.doctor.profile import check_profile, fast_dds
from blob_tracker.commands.doctor.python import check_libraries, check_python
from blob_tracker.commands.doctor.report import as_json, Report
from blob_tracker.commands.doctor.security import check_security
from blob_tracker.commands.doctor.shared_memory import check_shared_memory
from blob_tracker.resources import config_path

SELF_TEST = 'self-test'
Check = Callable[[], Iterable[Finding]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker doctor`."""
    parser.add_argument('--device', help='look at this camera alone, and read frames from it')
    parser.add_argument(
        '--no-self-test', action='store_true', help='leave out the 2 s of tracking by real nodes'
    )
    parser.add_argument('--json', action='store_true', help='for programs: a list of findings')


def main(arguments: argparse.Namespace) -> int:
    """
    Look at this machine.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        0 where nothing is an error, 1 where something is, 130 after Ctrl-C.

    """
    findings: list[Finding] = []
    report = Report()
    try:
        for subject, check in checks(arguments.device, not arguments.no_self_test):
            wrong = {finding.subject for finding in findings if finding.level is Level.ERROR}
            if subject == SELF_TEST and wrong & {'ROS', 'RMW'}:
                check = partial(_left_out, wrong)  # rclpy would end this process
            with nullcontext() if arguments.json else report.looking_at(subject):
                found = list(examined(subject, check))
            findings += found
            if not arguments.json:
                for finding in found:
                    report.tell(finding)
    except KeyboardInterrupt:
        return 130
    if arguments.json:
        print(as_json(findings))
    else:
        report.conclude(findings)
    return int(any(finding.level is Level.ERROR for finding in findings))


def examined(subject: str, check: Check) -> Iterator[Finding]:
    """Return the findings of a check, and that it failed as one more."""
    try:
        yield from check()
    except Exception as fault:  # whatever it is, the other checks go on
        yield error(
            subject,
            f'this could not be looked at: {type(fault).__name__}: {fault}',
            'report it with this sentence, if nothing above explains it',
        )


def checks(device: str | None, self_test: bool) -> Iterator[tuple[str, Check]]:
    """Return the checks in the order in which one thing needs another."""
    environment = dict(os.environ)
    imported = Path(blob_tracker.__file__).parent
    rclpy = _file_of('rclpy')
    folders = library_folders(environment, rclpy)
    yield 'Python', check_python
    yield 'libraries', check_libraries
    yield 'ROS', lambda: check_ros(environment, rclpy, _wheels())
    if rclpy is not None:
        yield 'RMW', lambda: check_rmw(environment, folders)
        yield 'TF', lambda: check_tf(environment, _file_of('tf2_msgs'))
        yield 'package', lambda: check_package(environment, imported)
    meant = Path('/') if installed_at(environment) else imported.parent
    yield 'kernels', lambda: check_compiled(environment, meant)
    if rclpy is not None:
        yield 'shared memory', check_shared_memory
        rmw = environment.get('RMW_IMPLEMENTATION') or DEFAULT_RMW
        yield 'Fast DDS', lambda: check_profile(environment, config_path('fastdds.xml'), rmw)
        yield 'discovery', lambda: check_domain(environment)
        yield 'discovery', lambda: check_range(environment)
        yield 'multicast', lambda: check_multicast(environment)
        yield 'security', lambda: check_security(environment, fast_dds(folders))
        yield 'log folder', lambda: check_log_folder(environment)
    if device is None:
        yield 'camera', check_cameras
    else:
        yield 'camera', lambda: check_stream(device)
    if self_test:
        yield SELF_TEST, lambda: _check_tracking(environment)


def _left_out(wrong: Collection[str]) -> Iterator[Finding]:
    """Say that the nodes were not tried, and for want of what."""
    causes = ' and '.join(sorted({'ROS', 'RMW'} & set(wrong)))
    yield warn(SELF_TEST, 'left out: no node can run here', f'see {causes} above')


def _check_tracking(environment: dict[str, str]) -> Iterable[Finding]:
    """Run the nodes; rclpy is loaded no sooner."""
    from blob_tracker.commands.doctor.self_test import check_tracking

    prefix = installed_at(environment)
    return check_tracking(environment, prefix and prefix / 'lib' / 'blob_tracker')


def _file_of(module: str) -> Path | None:
    """Return where Python finds a module, without loading it."""
    spec = find_spec(module)
    return None if spec is None or spec.origin is None else Path(spec.origin)


def _wheels() -> list[str]:
    """Return the installed wheels of rclpy, of whatever distribution."""
    names = {distribution.metadata['Name'] for distribution in metadata.distributions()}
    return sorted(name for name in names if name and name.startswith('ros-')
                  and name.endswith('-rclpy'))

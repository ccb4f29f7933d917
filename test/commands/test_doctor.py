"""The doctor as a whole: what it reports, and what it finds on this machine."""

from __future__ import annotations

from collections.abc import Iterable
import json
import os
from pathlib import Path
import subprocess
import sys

import blob_tracker
from blob_tracker.capture import CaptureError
from blob_tracker.commands.doctor import examined, installation, profile, security
from blob_tracker.commands.doctor.finding import error, Finding, Level, ok, warn
from blob_tracker.commands.doctor.report import as_json, Report, summary
import pytest
import rclpy
from support.slowness import slowness

DOCTOR = [sys.executable, '-m', 'blob_tracker', 'doctor']


def test_a_check_that_fails_is_a_finding() -> None:
    """And what it had found before counts."""

    def check() -> Iterable[Finding]:
        yield ok('disk', 'there is one')
        raise CaptureError('the moon is in the way')

    first, second = examined('disk', check)
    assert first.level is Level.OK
    assert second.level is Level.ERROR
    assert 'CaptureError: the moon is in the way' in second.message


def test_report(capsys: pytest.CaptureFixture[str]) -> None:
    """Level in words, markup left alone, commands on lines of their own; JSON holds it all."""
    findings = [ok('a', 'fine [red]'), warn('b', 'so so', 'do', 'export X=' + 'y' * 200),
                error('c', 'bad')]
    report = Report()
    for finding in findings:
        report.tell(finding)
    report.conclude(findings)
    lines = capsys.readouterr().out.splitlines()
    assert [line.rstrip() for line in lines] == [
        'OK     a               fine [red]',
        'WARN   b               so so; do:',
        f'       export X={"y" * 200}',
        'ERROR  c               bad',
        '',
        '1 error, 1 warning',
    ]
    assert json.loads(as_json(findings))[1] == {
        'level': 'WARN', 'subject': 'b', 'message': 'so so', 'advice': 'do',
        'command': f'export X={"y" * 200}',
    }
    assert summary(findings[:1]) == 'All is well.'


def run_doctor(*options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run it as a user does."""
    return subprocess.run([*DOCTOR, *options], capture_output=True, text=True,
                          timeout=100 * slowness(), env={**os.environ, **environment})


def test_real_nodes_pass_the_self_test() -> None:
    """Three processes, a truth to compare with, no error; exit code 0."""
    result = run_doctor('--json')
    findings = json.loads(result.stdout)
    assert not [f for f in findings if f['level'] == 'ERROR'], result.stdout
    assert result.returncode == 0
    # A machine busy with other tests may be told so, but bearings come and are right.
    (self_test,) = [f for f in findings if f['subject'] == 'self-test']
    assert ' px rms a coordinate' in self_test['message']
    for subject in ('Python', 'libraries', 'ROS', 'RMW', 'TF', 'package', 'kernels',
                    'shared memory', 'Fast DDS', 'discovery', 'security', 'log folder', 'camera'):
        assert [f for f in findings if f['subject'] == subject], subject
    library = profile.fast_dds(installation.library_folders(os.environ, Path(rclpy.__file__)))
    assert f'has {"the" if security.has_security(library) else "no"} security plugins' in next(
        f['message'] for f in findings if f['subject'] == 'security')


def test_a_middleware_that_is_not_there_does_not_end_the_doctor() -> None:
    """Whoever loads rclpy then is ended by it."""
    result = run_doctor(RMW_IMPLEMENTATION='rmw_no_such_cpp')
    assert result.returncode == 1
    assert 'ERROR  RMW' in result.stdout
    assert '1 error, ' in result.stdout
    assert 'left out: no node can run here; see RMW above' in result.stdout


def test_where_there_is_no_ros(tmp_path: Path) -> None:
    """The core alone: an error that says what still works, and no traceback."""
    (tmp_path / 'sitecustomize.py').write_text(
        'from importlib.machinery import PathFinder\n'
        'find = PathFinder.find_spec\n'
        "ROS = ('rclpy', 'ament_index_python', 'sensor_msgs')\n"
        'PathFinder.find_spec = lambda name, *rest: (\n'
        "    None if name.partition('.')[0] in ROS else find(name, *rest))\n"
    )
    package = Path(blob_tracker.__file__).parents[1]
    result = run_doctor(PYTHONPATH=f'{tmp_path}{os.pathsep}{package}')
    assert result.returncode == 1
    assert 'there is no rclpy for this Python' in result.stdout
    assert '1 error, ' in result.stdout
    assert 'Traceback' not in result.stdout + result.stderr

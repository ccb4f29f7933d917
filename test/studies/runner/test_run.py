"""The runner of the studies: what is kept, what fails, what is interrupted, and a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from math import isnan
from pathlib import Path
import signal
import subprocess
import sys
import time

from blob_tracker.__main__ import main
from blob_tracker.commands import study as command
from blob_tracker.commands.study import _chosen
from blob_tracker.studies.registry import STUDIES
from blob_tracker.studies.runner import run as runner
from blob_tracker.studies.runner.kept import Kept
from blob_tracker.studies.study import Case, Findings, Measured, Study
from distributed import LocalCluster
from matplotlib.figure import Figure
import pytest
from support.slowness import slowness

SMALL = 'figure_2_3'  # a study of less than a second
measured: list[int] = []


def _cases(quick: bool) -> list[Case]:
    return [{'number': number} for number in range(2 if quick else 4)]


def _measure(case: Case) -> Measured:
    if case['number'] < 0:
        raise ArithmeticError('below zero')
    measured.append(case['number'])
    return {'third': case['number'] / 3.0, 'nothing': float('nan'), 'pair': (1, 2)}


def _conclude(whole: Sequence[tuple[Case, Measured]]) -> Findings:
    return Findings(repr(whole), figures={'picture': Figure()})


def _wrong(whole: Sequence[tuple[Case, Measured]]) -> Findings:
    raise LookupError('no such column')


GOOD = Study('good', 'a', '', _cases, _measure, _conclude)
FAILING = Study('failing', 'b', '', lambda _: [{'number': -1}] * 2, _measure, _conclude)
WRONG = Study('wrong', 'c', '', _cases, _measure, _wrong)


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    measured.clear()
    for study in (GOOD, FAILING, WRONG):
        monkeypatch.setitem(STUDIES, study.name, study)


def _run(folder: Path, *studies: Study, quick: bool = True) -> dict[str, runner.Outcome]:
    """Run in threads, which see the studies of this file."""
    with ThreadPoolExecutor(2) as executor:
        outcomes = list(runner.run(
            studies, quick=quick, kept=Kept(folder), executor=executor, ahead=3,
            tick=lambda name: None,
        ))
    assert len({outcome.name for outcome in outcomes}) == len(outcomes) == len(studies)
    return {outcome.name: outcome for outcome in outcomes}


def test_what_was_measured_is_not_measured_again(tmp_path: Path) -> None:
    """The full run adds only what the quick one had not; the conclusion sees the same values."""
    first = _run(tmp_path, GOOD)
    assert sorted(measured) == [0, 1]
    again = _run(tmp_path, GOOD)
    assert sorted(measured) == [0, 1]
    assert again['good'].shows == first['good'].shows
    assert again['good'].pictures['picture'].startswith(b'\x89PNG')
    _run(tmp_path, GOOD, quick=False)
    assert sorted(measured) == [0, 1, 2, 3]


def test_kept_values_are_the_same_bits(tmp_path: Path) -> None:
    """A third and NaN survive the disk; another case is not mistaken for it."""
    kept = Kept(tmp_path)
    kept.put('good', {'number': 1}, {'third': 1 / 3, 'nothing': float('nan')})
    found = kept.get('good', {'number': 1})
    assert found is not None and found['third'] == 1 / 3 and isnan(found['nothing'])
    assert kept.get('good', {'number': 2}) is None
    assert kept.get('other', {'number': 1}) is None


def test_one_that_fails_does_not_stop_the_others(tmp_path: Path) -> None:
    """It says which case and why, once; a conclusion that fails says where."""
    outcomes = _run(tmp_path, FAILING, GOOD, WRONG)
    assert not outcomes['good'].failed
    assert outcomes['failing'].failed and outcomes['wrong'].failed
    assert 'ArithmeticError: below zero' in outcomes['failing'].shows
    assert "{'number': -1}" in outcomes['failing'].shows
    assert 'LookupError: no such column' in outcomes['wrong'].shows


def test_interrupted_and_resumed(tmp_path: Path) -> None:
    """Ctrl-C ends it with 130 and leaves whole files only; the next run begins with them."""
    words = [sys.executable, '-m', 'blob_tracker', 'study', 'table_3_5', '--quick', '--jobs', '1',
             '--out', str(tmp_path)]
    kept = tmp_path / 'kept'
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    try:
        while not (kept.is_dir() and list(kept.glob('*.json'))):
            assert process.poll() is None
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60.0 * slowness())[1]
    finally:
        process.kill()
        process.wait()
    before = set(kept.glob('*.json'))
    assert process.returncode == 130
    assert 'goes on from there' in said
    assert 0 < len(before) < len(STUDIES['table_3_5'].cases(True))
    times = {path: path.stat().st_mtime_ns for path in before}
    assert main(words[3:]) == 0
    assert {path: path.stat().st_mtime_ns for path in before} == times


def test_on_a_cluster(tmp_path: Path) -> None:
    """A real scheduler and a worker of it give the same numbers as this machine's processes."""
    words = ['study', SMALL, '--quick', '--out']
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        assert main([*words, str(tmp_path / 'a'), '--dask', cluster.scheduler_address]) == 0
    assert main([*words, str(tmp_path / 'b')]) == 0
    tables = [sorted((tmp_path / name / SMALL).glob('*.csv')) for name in 'ab']
    assert tables[0]
    for one, other in zip(*tables, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_a_figure_within_another_study_and_a_part_of_all(tmp_path: Path) -> None:
    """What has no study of its own is found by its number; the page of all stays as it is."""
    (tmp_path / 'report.html').write_text('of all')
    assert main(['study', 'figure_2_3', '--out', str(tmp_path)]) == 0
    assert (tmp_path / 'report.html').read_text() == 'of all'
    assert 'Rounding as noise' in (tmp_path / 'part.html').read_text()
    assert [study.name for study in _chosen(['figure_5_6'])] == ['table_5_5']


def test_a_worker_that_is_killed_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As it is where the memory ends: a line, and what was measured stays."""
    def broken(*_: object, **__: object) -> None:
        raise BrokenExecutor('a process of the pool is gone')

    monkeypatch.setattr(command, 'run', broken)
    assert main(['study', SMALL, '--out', str(tmp_path)]) == 1
    said = capsys.readouterr().err
    assert 'a process of the pool is gone' in said and 'is kept' in said


def test_no_cluster(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A scheduler that is not there is wrong use, said in a line."""
    words = ['study', SMALL, '--out', str(tmp_path), '--dask', 'tcp://127.0.0.1:9']
    assert main(words) == 2
    assert 'no Dask scheduler answers at tcp://127.0.0.1:9' in capsys.readouterr().err

"""The command: its exit code, and what it says of what is missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import json
from pathlib import Path
from typing import Any

from benchmarks import __main__, peers
from benchmarks.report import Report
from benchmarks.speed import Pace
import pytest

SCENES = ('7x7', '9x9', '15x15')


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Any]:
    """Return the command with rates in place of the measurement: exit code, text, record."""
    monkeypatch.setenv('COLUMNS', '180')

    def command(
        rates: Sequence[float] = (200e3, 200e3, 200e3), part: str = 'speed'
    ) -> tuple[int, str, Any]:
        report = Report(
            speed=[
                Pace(scene, 'maximum_likelihood', rate, 20e-6, 2.0, 10, 3)
                for scene, rate in zip(SCENES, rates)
            ]
        )
        monkeypatch.setattr(__main__, 'measure', lambda parts, *_: report if parts else Report())
        code = __main__.main([part, '--out', str(tmp_path)])
        record = json.loads((tmp_path / 'benchmarks.json').read_text())
        return code, capsys.readouterr().out, record

    return command


def test_all_targets_met(run: Callable[..., Any]) -> None:
    """Return 0 and say so."""
    code, text, record = run()
    assert code == 0
    assert 'missed' not in text
    assert record['targets'] and all(target['met'] for target in record['targets'])


def test_a_missed_target(run: Callable[..., Any]) -> None:
    """Return 1, and name the gap."""
    code, text, record = run(rates=(99e3, 200e3, 200e3))
    assert code == 1
    assert 'missed by 1.0%' in text
    assert [target['met'] for target in record['targets']].count(False) == 1


def test_a_missing_peer_is_listed_loudly(
    run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Name the package and why, in the table, in the last line and in the record."""
    monkeypatch.setattr(peers, 'PACKAGES', ('opencv', 'nonesuch'))
    code, text, record = run()
    assert code == 0
    assert 'nonesuch: MISSING' in text
    assert text.strip().splitlines()[-1] == 'not compared with nonesuch: not importable'
    assert 'nonesuch' in record['missing']['nonesuch']
    assert 'OpenCV moments' in record['settings']


def test_no_real_pixels(run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Say which variable is not set."""
    monkeypatch.delenv('BLOB_TRACKER_DATA', raising=False)
    code, text, _ = run(part='real')
    assert code == 0
    assert 'no real pixels: BLOB_TRACKER_DATA is not set' in text


def test_unknown_part(capsys: pytest.CaptureFixture[str]) -> None:
    """Refuse a part that is not there, and list those that are."""
    with pytest.raises(SystemExit, match='2'):
        __main__.main(['sped'])
    parts = (
        'accuracy, speed, real, detection, search, motion, tracking, capture, latency, world'
    )
    assert f'no part sped; there is {parts}' in capsys.readouterr().err


@pytest.mark.parametrize('arguments, why', [
    (['speed', '--beside', '.'], 'for the part latency alone'),
    (['latency', '--beside', '/nowhere'], 'no source tree'),
])
def test_what_cannot_be_beside(
    arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Refuse another part, and a folder without the benchmarks."""
    with pytest.raises(SystemExit, match='2'):
        __main__.main(arguments)
    assert why in capsys.readouterr().err

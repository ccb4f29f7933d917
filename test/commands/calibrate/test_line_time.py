"""`calibrate line_time` from end to end: a folder of frames, and what is wrong with a source."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.__main__ import main
import cv2
import numpy as np
import pytest
import yaml

LINE, HEIGHT = 30e-6, 480  # s, px


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of frames of a wall in the light of a lamp of 100 Hz."""
    path = tmp_path_factory.mktemp('wall')
    random = np.random.default_rng(2)
    for index in range(12):
        seen = index / 29.97 + LINE * np.arange(HEIGHT)
        light = 80.0 * (1.0 + 0.2 * np.cos(2.0 * np.pi * 100.0 * seen))
        pixels = light[:, None] + random.normal(0.0, 2.0, (HEIGHT, 24))
        assert cv2.imwrite(str(path / f'{index}.png'), np.rint(pixels).astype(np.uint8))
    return path


def test_the_line_time_is_told_and_written(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As a parameter to copy, a parameter file for three nodes, and a picture."""
    out = tmp_path / 'line_time.yaml'
    words = ['calibrate', 'line_time', str(folder), '--frequency', '100', '--out', str(out)]
    assert main(words) == 0
    printed = capsys.readouterr().out
    told = float(printed.split('-p line_time:=')[1].split()[0])
    assert told == pytest.approx(LINE, rel=1e-3)
    assert 'and assumed' in printed  # a folder has no stamps
    written = yaml.safe_load(out.read_text())
    assert set(written) == {'/**/camera', '/**/segmenter', '/**/locator'}
    for node in written.values():
        assert node['ros__parameters']['line_time'] == pytest.approx(told, abs=1e-9)
    assert out.with_suffix('.png').stat().st_size > 10_000


@pytest.mark.parametrize(('words', 'code', 'reason'), [
    ([], 1, 'give --frequency'),
    (['--frequency', '100', '--count', '3'], 1, 'there must be 4 or more'),
    (['--frequency', '100', '--out', 'picture.png'], 2, 'name of the picture'),
])
def test_what_is_wrong_is_said(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str], words: list[str], code: int, reason: str,
) -> None:
    """In one sentence, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    assert main(['calibrate', 'line_time', str(folder), *words]) == code
    assert reason in capsys.readouterr().err
    assert not list(tmp_path.iterdir())

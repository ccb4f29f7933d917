"""Frames to try the tracker on: what the example writes, `track` finds."""

from __future__ import annotations

import csv
from pathlib import Path
import subprocess
import sys

from blob_tracker.__main__ import main as blob_tracker

EXAMPLE = Path(__file__).parents[2] / 'examples/simulated_frames.py'


def test_what_it_writes_is_tracked_by_the_command_that_it_prints(tmp_path: Path) -> None:
    """Half of the frames have a light, but for those before it is confirmed."""
    folder = tmp_path / 'light'
    command = [sys.executable, str(EXAMPLE), str(folder)]
    printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    out = tmp_path / 'track.csv'
    assert blob_tracker([*printed.splitlines()[-1].split()[1:], '--out', str(out)]) == 0
    rows = list(csv.DictReader(out.open(encoding='utf-8')))
    assert len(rows) == len(list(folder.iterdir()))
    assert sum(bool(row['x_px']) for row in rows) >= 0.45 * len(rows)


def test_its_help_writes_nothing(tmp_path: Path) -> None:
    """Nor do options that it does not have."""
    for word, code in (('--help', 0), ('--frame', 2), ('--speed', 2)):
        command = [sys.executable, str(EXAMPLE), word]
        ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert ended.returncode == code
        assert 'usage: simulated_frames.py' in ended.stdout + ended.stderr
    assert not list(tmp_path.iterdir())

"""Frames to try the tracker on: what the example writes, `track` finds."""

from __future__ import annotations

import csv
from pathlib import Path

from blob_tracker.__main__ import main as blob_tracker
from examples.simulated_frames import FRAMES, main
import pytest


def test_what_it_writes_is_tracked_by_the_command_that_it_prints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half of the frames have a light, but for those before it is confirmed."""
    main(tmp_path / 'light')
    words = capsys.readouterr().out.splitlines()[-1].split()
    out = tmp_path / 'track.csv'
    assert blob_tracker([*words[1:], '--out', str(out)]) == 0
    rows = list(csv.DictReader(out.open(encoding='utf-8')))
    assert sum(bool(row['x_px']) for row in rows) >= 0.45 * FRAMES

"""ament_flake8, ament_pep257 and mypy find nothing."""

from __future__ import annotations

from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).parents[1]
PLACES = ['blob_tracker', 'test', 'launch', 'benchmarks', 'examples', 'tools', 'setup.py']


@pytest.mark.parametrize('linter', ['ament_flake8', 'ament_pep257'])
def test_linter_finds_nothing(linter: str) -> None:
    """The ROS linters with their own settings."""
    places = [str(ROOT / place) for place in PLACES if (ROOT / place).exists()]
    result = subprocess.run(
        [sys.executable, '-m', f'{linter}.main', *places], capture_output=True, text=True
    )
    assert result.returncode == 0, result.stdout[-4000:] + result.stderr[-2000:]


def test_types_are_consistent(tmp_path: Path) -> None:
    """The package in mypy's strict form, and all that is beside it: see pyproject.toml."""
    result = subprocess.run(
        [sys.executable, '-m', 'mypy', '--cache-dir', str(tmp_path)],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert result.returncode == 0, result.stdout[-4000:]

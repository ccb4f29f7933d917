"""Who waits for the compiler is told, and nobody else."""

from __future__ import annotations

from pathlib import Path
import subprocess
import sys

from blob_tracker.kernel.notice import before_compiling, COMPILING, compiling
import pytest

CALLS = """\
from blob_tracker.kernel import kernel
from blob_tracker.kernel.notice import before_compiling

@kernel
def square(x):
    return x * x

@kernel
def fourth(x):
    return square(square(x))

before_compiling(print)
assert fourth(3.0) == 81.0
"""


def test_it_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever asked last is told; nobody is where nobody asked."""
    compiling()
    before_compiling(lambda sentence: pytest.fail(sentence))
    before_compiling(print)
    compiling()
    compiling()
    assert capsys.readouterr().out == f'{COMPILING}\n'


def test_it_is_told_where_something_is_compiled(tmp_path: Path) -> None:
    """By the first process; the second one loads what that has kept."""
    (tmp_path / 'calls.py').write_text(CALLS)
    said = [
        subprocess.run(
            [sys.executable, 'calls.py'], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    ]
    assert said == [f'{COMPILING}\n', '']

"""Machine code on disk is used again until any source of the room changes."""

from __future__ import annotations

from pathlib import Path
import shutil
import subprocess
import sys

import blob_tracker

CALL = (
    'from small.location.caller import outer; outer(2.0); '
    'print(outer(2.0), sum(outer.stats.cache_hits.values()))'
)


PASS = (
    'from small.location.passed import Pair{0}, total; total(Pair{0}(2.0)); '
    'print(total(Pair{0}(2.0)), sum(total.stats.cache_hits.values()))'
)


def answer(folder: Path, call: str = CALL) -> tuple[float, int]:
    """Run the kernel in a process of its own; return its value and how often it was loaded."""
    result = subprocess.run(
        [sys.executable, '-c', call], cwd=folder, capture_output=True, text=True, check=True
    )
    value, hits = result.stdout.split()
    return float(value), int(hits)


def small_room(folder: Path) -> Path:
    """Make a package with a room; return the room's folder."""
    room = folder / 'small' / 'location'
    room.mkdir(parents=True)
    source = Path(blob_tracker.__file__).parent / 'kernel.py'
    shutil.copy(source, folder / 'small' / 'kernel.py')
    return room


def test_a_change_in_a_called_kernel_reaches_the_caller(tmp_path: Path) -> None:
    """The caller's own file is untouched, and yet it must not go on with the old code."""
    room = small_room(tmp_path)
    head = 'from small.kernel import kernel\n'
    called = head + '@kernel\ndef inner(x):\n    return x + {}\n'
    (room / 'called.py').write_text(called.format(1.0))
    (room / 'caller.py').write_text(
        head
        + 'from small.location.called import inner\n'
        + '@kernel\ndef outer(x):\n    return 10.0 * inner(x)\n'
    )
    assert answer(tmp_path) == (30.0, 0)
    assert answer(tmp_path) == (30.0, 1)
    (room / 'called.py').write_text(called.format(2.0))
    assert answer(tmp_path) == (40.0, 0)


def test_an_argument_whose_class_was_renamed(tmp_path: Path) -> None:
    """What was kept for the old class is passed over, not tripped over."""
    room = small_room(tmp_path)
    source = (
        'from typing import NamedTuple\n'
        'from small.kernel import kernel\n'
        'class Pair{0}(NamedTuple):\n    first: float\n'
        '@kernel\ndef total(pair):\n    return 10.0 * pair.first\n'
    )
    for name in ('', 'Anew'):
        (room / 'passed.py').write_text(source.format(name))
        assert answer(tmp_path, PASS.format(name)) == (20.0, 0)
        assert answer(tmp_path, PASS.format(name)) == (20.0, 1)

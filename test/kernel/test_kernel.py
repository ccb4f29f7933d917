"""Machine code on disk is used again until something that it is compiled from changes."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
import math
import os
from pathlib import Path
import platform
import shutil
import subprocess
import sys
from types import ModuleType
from typing import Any

import blob_tracker
from blob_tracker.kernel import fingerprint, kernel
import numpy as np
import pytest

CALL = (
    'import sys; from small.location.caller import outer; outer(2.0); '
    'print(outer(2.0), "numba" not in sys.modules)'
)
INNER = 'from small.kernel import kernel\n{}@kernel\ndef inner(x):\n    return x + {}\n'
OUTER = """\
from small.kernel import kernel
from small.{room}.called import inner
{comment}
FACTOR = {factor}
@kernel
def outer(x):
    {comment}
    return FACTOR * inner(x)
"""


@kernel
def inner(x: float, doubled: bool, times: int) -> float:
    """Return x times a number, or twice as much."""
    return times * (2.0 * x if doubled else x)


@kernel
def outer(x: float, times: int) -> float:
    """Call the other one with numbers that are written out, and with such that are not."""
    return inner(x, True, times) + inner(x, doubled=False, times=3) + inner(x, x < 0.0, -1)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Make a package with two rooms, a kernel in each: outer(x) is 10 (x + 1)."""
    for room in ('location', 'tracking'):
        (tmp_path / 'small' / room).mkdir(parents=True)
        (tmp_path / 'small' / room / 'called.py').write_text(INNER.format('', 1.0))
    source = Path(blob_tracker.__file__).parent / 'kernel'
    shutil.copytree(source, tmp_path / 'small' / 'kernel')
    write_outer(tmp_path)
    return tmp_path


def write_outer(
    package: Path, room: str = 'location', comment: str = '', factor: float = 10.0
) -> None:
    """Write the kernel that calls the one in a room."""
    text = OUTER.format(room=room, comment=comment, factor=factor)
    (package / 'small/location/caller.py').write_text(text)


PASS = (
    'import sys; from small.location.passed import Pair{0}, total; total(Pair{0}(2.0)); '
    'print(total(Pair{0}(2.0)), "numba" not in sys.modules)'
)
direct = pytest.mark.skipif(
    find_spec('blob_tracker.kernel.direct') is None, reason='built without a C compiler'
)


def answer(folder: Path, call: str = CALL) -> tuple[float, bool]:
    """Run the kernel in a process of its own; return its value, and whether it was loaded."""
    result = subprocess.run(
        [sys.executable, '-c', call], cwd=folder, capture_output=True, text=True, check=True
    )
    value, hits = result.stdout.split()
    return float(value), hits == 'True'


@direct
def test_a_change_in_a_called_kernel_reaches_the_caller(package: Path) -> None:
    """The caller's own file is untouched, and yet it must not go on with the old code."""
    assert answer(package) == (30.0, False)
    assert answer(package) == (30.0, True)
    (package / 'small/location/called.py').write_text(INNER.format('', 2.0))
    assert answer(package) == (40.0, False)


@direct
def test_comments_moved_lines_and_other_files_compile_nothing(package: Path) -> None:
    """Nor does the package in another folder, where its machine code has come along."""
    assert answer(package) == (30.0, False)
    write_outer(package, comment='# a comment\n# of two lines')
    (package / 'small/location/called.py').write_text(INNER.format('\n\nOTHER = 1\n\n', 1.0))
    (package / 'small/location/more.py').write_text('MORE = 1\n')
    (package / 'moved').mkdir()
    shutil.move(package / 'small', package / 'moved')
    assert answer(package / 'moved') == (30.0, True)


@direct
def test_an_argument_whose_class_was_renamed(package: Path) -> None:
    """What was kept for the old class is passed over, not tripped over."""
    source = (
        'from typing import NamedTuple\n'
        'from small.kernel import kernel\n'
        'class Pair{0}(NamedTuple):\n    first: float\n'
        '@kernel\ndef total(pair):\n    return 10.0 * pair.first\n'
    )
    for name in ('', 'Anew'):
        (package / 'small/location/passed.py').write_text(source.format(name))
        assert answer(package, PASS.format(name)) == (20.0, False)
        assert answer(package, PASS.format(name)) == (20.0, True)


@direct
def test_constants_and_kernels_of_another_room_are_compiled_in(package: Path) -> None:
    """What is read by name is frozen into the machine code, from wherever it comes."""
    write_outer(package, 'tracking')
    assert answer(package) == (30.0, False)
    write_outer(package, 'tracking', factor=5.0)
    assert answer(package) == (15.0, False)
    (package / 'small/tracking/called.py').write_text(INNER.format('', 2.0))
    assert answer(package) == (20.0, False)


ARGUMENTS = """\
import sys
from typing import NamedTuple
import numpy as np
from blob_tracker.kernel import kernel
class Pair(NamedTuple):
    first: np.ndarray
    second: float
@kernel
def summed(pair, count):
    if count < 0:
        raise ValueError('fewer than none')
    total = np.zeros_like(pair.first)
    for i in range(count):
        total += pair.first * pair.second
    return Pair(total, total.sum())
"""
CALLS = """\
from given import *
def called(*arguments):
    try:
        first, second = summed(*arguments)
        assert isinstance(summed(*arguments), Pair)
        return first.tolist(), first.dtype.str, second
    except Exception as error:
        return type(error).__name__, str(error).splitlines()[0][:30]
a = np.arange(6.0)
print(called(Pair(a, 2.0), 3), called(Pair(a, np.float64(2.0)), np.int64(3)))
print(called(Pair(a, 2.0), -1), called(Pair(a, 2.0), 1 << 70))
print('numba' in sys.modules, flush=True)
if sys.argv[1:]:
    sys.exit()
assert sys.getrefcount(a) == 2
print(called(Pair(a[::2], 2.0), 3))
print(called(Pair(a.astype(np.float32), 2.0), 3))
print(called(Pair(a.reshape(2, 3).T, 2.0), 3))
print(called(Pair(np.frombuffer(bytes(49), np.float64, 6, 1), 2.0), 3))
a.flags.writeable = False
print(called(Pair(a, 2.0), 3), called((a, 2.0), 3)[0], called(Pair(a, None), 3)[0])
print(called(Pair(a, 2.0)), called(), called(3, Pair(a, 2.0))[0])
print(summed(count=1, pair=Pair(a, 1.0)))
"""


# As on a user's machine: continuous integration compiles for any x86-64.
NATIVE = {name: value for name, value in os.environ.items() if not name.startswith('NUMBA_CPU')}


@direct
def test_types_are_told_apart_and_errors_come_through(tmp_path: Path) -> None:
    """Other layouts, kinds and classes never reach code made for others: Numba says the same."""
    (tmp_path / 'given.py').write_text(ARGUMENTS)
    (tmp_path / 'calls.py').write_text(CALLS)

    def printed(*some: str, **more: str) -> list[str]:
        return subprocess.run(
            [sys.executable, 'calls.py', *some], cwd=tmp_path, capture_output=True, text=True,
            check=True, env={**NATIVE, **more},
        ).stdout.splitlines()

    first = printed()  # by Numba
    assert first[0].count('[0.0, 6.0, 12.0, 18.0, 24.0, 30.0]') == 2
    assert 'fewer than none' in first[1]
    assert 'OverflowError' in first[1]
    again = printed()
    assert (first[2], again[2]) == ('True', 'False')
    assert first[:2] + first[3:] == again[:2] + again[3:]
    # What is kept is not for another processor, nor damaged.
    assert printed('some', NUMBA_CPU_NAME='generic')[2] == 'True'
    for path in tmp_path.rglob('*.nbm'):
        path.write_bytes(path.read_bytes()[:-100])
    assert printed('some') == first[:3]


@direct
@pytest.mark.skipif(platform.machine() != 'x86_64', reason='machine code of others is not loaded')
def test_what_the_nodes_call_needs_no_compiler(tmp_path: Path) -> None:
    """All of it can be kept: no argument is of a type that only Numba can tell."""
    call = (
        'import sys; from blob_tracker.pipeline import compile_ahead; '
        'compile_ahead(["maximum_likelihood"]); print("numba" in sys.modules)'
    )
    for _ in range(2):  # the first may compile
        result = subprocess.run(
            # Not here, where the source tree would be imported in place of what is installed.
            [sys.executable, '-c', call], cwd=tmp_path, capture_output=True, text=True, check=True
        )
    assert result.stdout == 'False\n'


def test_a_number_that_is_written_out_is_any_number() -> None:
    """A kernel that others call with constants is compiled once, not for each of them."""
    assert outer(2.0, 4) == 16.0 + 6.0 - 2.0
    called: Any = inner
    assert len(called.compiler._cache._cache_file._load_index()) == 1


# --- What the fingerprint changes with ---


def test_exact_arithmetic_is_other_machine_code() -> None:
    """It is the licence to reorder that differs."""
    def sums(x: float) -> float:
        return x + 1.0

    before = fingerprint(sums)
    vars(sums)['is_exact'] = True
    assert fingerprint(sums) != before


SOURCE = """\
LEVELS = (1, 2.0, frozenset('abcd'))
WEIGHTS = np.array([1.0, 2.0])
Pair = namedtuple('Pair', 'x y')
def parts(n):
    return range(n)
def outer(x, step=3):
    'Say something.'
    if x < 0:
        return outer(-x)
    total = [part * math.pi for part in parts(3)]
    pair = Pair(LEVELS[0], WEIGHTS[1])
    return later(x) + total[0] + pair.x + np.linalg.norm(WEIGHTS) + other.inner(x) + step
def later(x: float):
    return x + other.OFFSET
def unused(x):
    return x
"""
OTHER = 'OFFSET = 1\nUNUSED = 1\ndef inner(x):\n    return x\n'


def printed(old: str = '', new: str = '') -> str:
    """Return the fingerprint of `outer`, with a part of the source replaced."""
    assert old in SOURCE + OTHER
    other, module = ModuleType('small.other'), ModuleType('small.module')
    exec(OTHER.replace(old, new), vars(other))
    vars(module).update(other=other, np=np, math=math, namedtuple=namedtuple)
    exec(SOURCE.replace(old, new), vars(module))
    return fingerprint(vars(module)['outer'])


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('def later', '# a comment\n\ndef later'),
        ('Say something', 'Say something else'),
        ('x: float', 'x: int'),
        ("frozenset('abcd')", "frozenset('dcba')"),
        ('unused(x):\n    return x', 'unused(x):\n    return -x'),
        ('UNUSED = 1', 'UNUSED = 2'),
        ('[1.0, 2.0]', '[np.nextafter(1.0, 2.0), np.nextafter(2.0, 1.0)]'),
    ],
)
def test_what_is_not_compiled_in_does_not_count(old: str, new: str) -> None:
    """
    Comments, docstrings, annotations, the order in a set, and what nobody reads.

    Nor the last bits of an array, which are computed otherwise on another processor.
    """
    assert printed(old, new) == printed()


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('outer(-x)', 'outer(x)'),
        ('other.OFFSET', 'OFFSET'),
        ('range(n)', 'range(n + 1)'),
        ('math.pi', 'math.e'),
        ('linalg.norm', 'linalg.det'),
        ('LEVELS = (1', 'LEVELS = (True'),
        ('LEVELS = (1, 2.0', 'LEVELS = (1, -2.0'),
        ("frozenset('abcd')", "frozenset('abc')"),
        ('[1.0, 2.0]', '[1.0, 3.0]'),
        ('[1.0, 2.0]', '[1.0 + 1e-9, 2.0]'),
        ('[1.0, 2.0]', '[2.0, 4.0]'),
        ('[1.0, 2.0]', '[1.0, np.nan]'),
        ('[1.0, 2.0]', '[1, 2]'),
        ("'x y'", "'y x'"),
        ('step=3', 'step=4'),
        ('OFFSET = 1', 'OFFSET = 2'),
        ('inner(x):\n    return x', 'inner(x):\n    return -x'),
    ],
)
def test_all_that_is_compiled_in_counts(old: str, new: str) -> None:
    """Code, names, constants and their types, fields, defaults, and the same of what is called."""
    assert printed(old, new) != printed()


FINGERPRINTS = """
import blob_tracker.constellation, blob_tracker.pipeline
from blob_tracker import kernel
for each in kernel._KERNELS:
    print(each.py_func.__module__, each.py_func.__qualname__, kernel.fingerprint(each.py_func))
"""


def test_a_processor_with_fewer_instructions_takes_the_same_machine_code() -> None:
    """Constants that NumPy computes with what there is differ in their last bits alone."""
    optional: list[str] = import_module('numpy._core._multiarray_umath').__cpu_dispatch__
    many, few = (
        subprocess.run(
            [sys.executable, '-c', FINGERPRINTS], capture_output=True, text=True, check=True,
            env=os.environ | {'NPY_DISABLE_CPU_FEATURES': ' '.join(without)},
        ).stdout.splitlines()
        for without in (optional[:0], optional)
    )
    assert len(many) > 200
    assert few == many


def test_what_encloses_a_kernel_counts() -> None:
    """Two kernels of one source that were made with different values."""
    def made(value: float) -> Callable[[float], float]:
        def inner(x: float) -> float:
            return x + value
        return inner

    assert fingerprint(made(1.0)) == fingerprint(made(1.0))
    assert fingerprint(made(1.0)) != fingerprint(made(2.0))


def test_what_cannot_be_told_apart_is_refused() -> None:
    """A kernel must not go on with the old code because two values print alike."""
    with pytest.raises(TypeError, match='outer reads a dict'):
        printed("LEVELS = (1, 2.0, frozenset('abcd'))", 'LEVELS = {0: 1}')

"""Machine code that is kept on disk so that Numba need not be imported: a file a kernel."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha1
from importlib.util import find_spec
from itertools import takewhile
import os
from pathlib import Path
import pickle
import re
import sys
from typing import Any, NamedTuple

from blob_tracker.kernel.changes import fingerprint
from blob_tracker.kernel.machine_code import Image
import numpy as np

SUFFIX = '.nbm'  # beside Numba's .nbi and .nbc
FORMAT = 'linked'  # of what is in it: another one is not read
# Of /proc/cpuinfo: what LLVM tells a processor by.
PROCESSOR = re.compile(r'^(?:vendor_id|cpu family|model|stepping|flags)\s*:.*$', re.M)
NO_MATTER = ('NUMBA_CACHE_DIR',)


class CODES:
    """How `direct.c` is told the types of arguments."""

    ARRAY, FLOAT, INTEGER, BOOLEAN, NONE, TEXT, TUPLE = range(7)


class Kept(NamedTuple):
    """
    The machine code of a kernel for one signature.

    Parameters
    ----------
    codes : bytes
        The types of the arguments, see `direct.c`.
    values : int
        How many arguments there are.
    wrapper : str
        The symbol that is called.
    image : Image
        The machine code.
    pickled : bytes
        The classes that the codes name, and the environments: symbol, module, constants.

    """

    codes: bytes
    values: int
    wrapper: str
    image: Image
    pickled: bytes


def read(function: Callable[..., Any]) -> list[Kept]:
    """Return what is kept of a kernel for this processor, these versions and this source."""
    found = []
    name = _name(function)
    for folder in _folders(
        os.path.dirname(function.__code__.co_filename),
        *map(os.environ.get, ('NUMBA_CACHE_DIR', 'XDG_CACHE_HOME')),
    ):
        try:
            with open(os.path.join(folder, name), 'rb') as file:
                stamp, rows = pickle.load(file)
            if stamp == _stamp(function):
                found += [Kept(*row) for row in rows]
        except (
            OSError, ValueError, TypeError, EOFError, IndexError, AttributeError,
            pickle.UnpicklingError,
        ):
            continue
    return found


def write(function: Callable[..., Any], folder: Path, new: list[Kept]) -> None:
    """Keep more signatures of a kernel; where nothing can be written, do without."""
    rows = {one.codes + one.pickled: tuple(one) for one in (*read(function), *new)}
    path = folder / _name(function)
    beside = path.with_suffix(f'.{os.getpid()}')
    try:
        beside.write_bytes(pickle.dumps((_stamp(function), list(rows.values()))))
        beside.replace(path)
    except OSError:
        beside.unlink(missing_ok=True)


def classes(one: Kept) -> tuple[type, ...]:
    """Return the classes of the tuples that it takes."""
    found: tuple[type, ...] = pickle.loads(one.pickled)[0]
    return found


def _name(function: Callable[..., Any]) -> str:
    plain = re.sub(r'\W', '_', function.__qualname__)
    stem = Path(function.__code__.co_filename).stem
    return f'{stem}.{plain}.{sys.implementation.cache_tag}{SUFFIX}'


@cache  # a room has many kernels
def _folders(room: str, chosen: str | None, home: str | None) -> list[Path]:
    """Return where Numba keeps its files of a folder of sources, in the order in which it asks."""
    source = Path(room).absolute()
    own = f'{source.name}_{sha1(str(source).encode()).hexdigest()}'
    if chosen:
        return [Path(chosen) / own]
    return [source / '__pycache__', Path(home or Path.home() / '.cache') / 'numba' / own]


def _stamp(function: Callable[..., Any]) -> tuple[str, ...]:
    return (*_surroundings(), fingerprint(function))


@cache
def _surroundings() -> tuple[str, ...]:
    """Return what machine code depends on besides the source: versions, settings, processor."""
    spec = find_spec('numba')
    version = Path(str(spec and spec.origin)).with_name('_version.py').read_text()
    settings = {
        name: value for name, value in os.environ.items()
        if name.startswith('NUMBA_') and name not in NO_MATTER
    }
    processor = ''
    if settings.get('NUMBA_CPU_NAME', 'host') == 'host':
        with open('/proc/cpuinfo') as file:
            first = ''.join(takewhile(str.strip, file))
            processor = '\n'.join(PROCESSOR.findall(first))
    return FORMAT, version, np.__version__, sys.version, repr(sorted(settings.items())), processor

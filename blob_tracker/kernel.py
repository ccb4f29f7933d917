"""How the loops over pixels are compiled, and the arrays that they take."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from numba import njit
import numpy as np
from numpy.typing import NDArray

# Everything but the licence to ignore NaN and infinity: a masked pixel's variance is infinite.
FAST = {'reassoc', 'contract', 'nsz', 'arcp'}

Array = NDArray[np.float64]
Kernel = TypeVar('Kernel', bound=Callable[..., Any])
_KERNELS: list[Any] = []  # all that the rooms imported so far have


@cache
def _digest(room: Path) -> str:
    """Return what changes with any source file of a folder."""
    digest = sha256()
    for path in sorted(room.glob('*.py')):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def kernel(function: Kernel) -> Kernel:
    """Compile for one core at the first call, and keep the machine code on disk."""
    compiled = njit(cache=True, fastmath=FAST)(function)
    # Numba looks for changes in the kernel's own file, but the kernels that it calls are compiled
    # into it: after an upgrade it would go on with their old code. So any file of its room counts.
    if hasattr(compiled, '_cache'):  # not where NUMBA_DISABLE_JIT is set
        digest = _digest(Path(function.__code__.co_filename).parent)
        file = compiled._cache._cache_file
        file._source_stamp = digest
        # The version is looked at first: to get at the stamp, Numba unpickles the types of the
        # arguments as well, and fails where a class among them has another name since.
        file._version = f'{file._version} {digest}'
        _KERNELS.append(compiled)
    return compiled


def compiled(name: str) -> tuple[int, int, str]:
    """
    Tell which kernels of a module, or package, that is imported are compiled and kept on disk.

    Returns
    -------
    int, int, str
        How many are compiled for this processor from the source that is there, how many there
        are, and the folder with the machine code (that of the first one).

    """
    kernels = [one for one in _KERNELS if f'{one.py_func.__module__}.'.startswith(f'{name}.')]
    processor = kernels[0].targetctx.codegen().magic_tuple()
    done = sum(
        any(key[1] == processor for key in one._cache._cache_file._load_index())
        for one in kernels
    )
    return done, len(kernels), str(kernels[0]._cache._cache_path)

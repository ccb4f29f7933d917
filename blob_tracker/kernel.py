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
        room = Path(function.__code__.co_filename).parent
        compiled._cache._cache_file._source_stamp = _digest(room)
    return compiled

"""How the loops over pixels are compiled, and the arrays that they take."""

from __future__ import annotations

from collections.abc import Callable
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


def _digest() -> str:
    """Return what changes with any source file of this folder."""
    digest = sha256()
    for path in sorted(Path(__file__).parent.glob('*.py')):
        digest.update(path.read_bytes())
    return digest.hexdigest()


_SOURCES = _digest()


def kernel(function: Kernel) -> Kernel:
    """Compile for one core at the first call, and keep the machine code on disk."""
    compiled = njit(cache=True, fastmath=FAST)(function)
    # Numba looks for changes in the kernel's own file, but the kernels that it calls are compiled
    # into it: after an upgrade it would go on with their old code. So any file counts.
    if hasattr(compiled, '_cache'):  # not where NUMBA_DISABLE_JIT is set
        compiled._cache._cache_file._source_stamp = _SOURCES
    return compiled

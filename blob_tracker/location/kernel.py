"""How the loops over pixels are compiled, and the arrays that they take."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit
import numpy as np
from numpy.typing import NDArray

# Everything but the licence to ignore NaN and infinity: a masked pixel's variance is infinite.
FAST = {'reassoc', 'contract', 'nsz', 'arcp'}

Array = NDArray[np.float64]
Kernel = TypeVar('Kernel', bound=Callable[..., Any])


def kernel(function: Kernel) -> Kernel:
    """Compile for one core at the first call, and keep the machine code on disk."""
    return njit(cache=True, fastmath=FAST)(function)

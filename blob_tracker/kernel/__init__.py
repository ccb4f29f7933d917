"""How the loops over pixels are compiled, kept on disk and found again."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, update_wrapper
import os
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

from blob_tracker.kernel import kept
from blob_tracker.kernel.changes import fingerprint
import numpy as np
from numpy.typing import NDArray

try:
    from blob_tracker.kernel.direct import Direct
except ImportError:  # built without a C compiler
    Direct = object  # type: ignore[assignment, misc]

__all__ = [
    'Array', 'compiled', 'exact_kernel', 'fingerprint', 'kernel', 'written_into_kernels',
]

Array = NDArray[np.float64]
Kernel = TypeVar('Kernel', bound=Callable[..., Any])
_KERNELS: list[Any] = []  # all that the rooms imported so far have
_LOCK = RLock()


def kernel(function: Kernel) -> Kernel:
    """
    Compile for one core at the first call, and keep the machine code on disk.

    It is compiled again when its own code changes, or that of a kernel that it calls, or a
    constant that one of them reads: see `fingerprint`. Numba is imported when it is needed for
    that.
    """
    made: Any = _made(function, 'never')
    if made is not function:
        _KERNELS.append(made)
    return made


def exact_kernel(function: Kernel) -> Kernel:
    """
    Compile as `kernel` does, but to what Python itself would compute, to the last bit.

    For arithmetic on a few numbers, in which the compiler's licence to reorder saves nothing.
    """
    vars(function)['is_exact'] = True
    return kernel(function)


def written_into_kernels(function: Kernel) -> Kernel:
    """
    Take a part of a kernel that is written into each that calls it, before they are compiled.

    A call leaves the compiler less to reorder: a kernel that has it is slower, and rounds
    otherwise, than one that does all by itself.
    """
    part: Kernel = _made(function, 'always')
    return part


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
    return done, len(kernels), str(kernels[0]._cache.cache_path)


def _made(function: Callable[..., Any], inline: str) -> Any:
    """Return the function for where nothing is compiled, otherwise what calls machine code."""
    if int(os.environ.get('NUMBA_DISABLE_JIT') or 0):
        return function
    return _Kernel(function, inline) if Direct is not object else _compiler(function, inline)


def _compiler(function: Callable[..., Any], inline: str) -> Any:
    from blob_tracker.kernel.compiler import compiler
    return compiler(function, inline)


class _Kernel(Direct):
    """
    A kernel that loads machine code, and has Numba make what there is none for.

    A call that has machine code goes to it without a line of Python.
    """

    def __init__(self, function: Callable[..., Any], inline: str = 'never') -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._inline = inline
        self._is_read = False
        self._known: set[Any] = set()  # signatures that Numba has made in this process

    def __getattr__(self, name: str) -> Any:
        """Return what Numba's dispatcher has by that name: its compiler asks for it."""
        if name.startswith('__'):
            raise AttributeError(name)
        return getattr(self.compiler, name)

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    @cached_property
    def compiler(self) -> Any:
        """Numba's dispatcher."""
        return _compiler(self.py_func, self._inline)

    def missed(self, *arguments: Any, **named: Any) -> Any:
        """Answer a call that no machine code is loaded for."""
        with _LOCK:
            first = not self._is_read
            self._is_read = True
            if first and self._inline == 'never':
                self._read()
        if first and self.count:
            return self(*arguments, **named)
        result = self.compiler(*arguments, **named)
        if len(getattr(self.compiler, 'overloads', ())) != len(self._known):
            with _LOCK:
                self._keep()
        return result

    def _read(self) -> None:
        """Take the machine code that is on disk."""
        from blob_tracker.kernel.runtime import placed
        for one in kept.read(self.py_func):
            found = placed(one)
            if found is not None:
                self.add(one.codes, one.values, *found)

    def _keep(self) -> None:
        """Call directly what Numba has made, and keep it on disk."""
        from blob_tracker.kernel.compiler import wrappers
        new = []
        for signature, one, address in wrappers(self.compiler, self._known):
            self._known.add(signature)
            if one is not None:
                self.add(one.codes, one.values, kept.classes(one), address)
                new.append(one)
        if new:
            kept.write(self.py_func, Path(self._cache.cache_path), new)

"""How the loops over pixels are compiled, kept on disk and found again."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

from numba import njit
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
import numpy as np
from numpy.typing import NDArray

# Everything but the licence to ignore NaN and infinity: a masked pixel's variance is infinite.
FAST = {'reassoc', 'contract', 'nsz', 'arcp'}
# What a kernel may read, and what its repr tells all of.
CONSTANTS = (bool, int, float, complex, str, bytes, type(None), type(...), np.generic, np.dtype)

Array = NDArray[np.float64]
Kernel = TypeVar('Kernel', bound=Callable[..., Any])
_KERNELS: list[Any] = []  # all that the rooms imported so far have


def kernel(function: Kernel) -> Kernel:
    """
    Compile for one core at the first call, and keep the machine code on disk.

    It is compiled anew when its own code changes, or that of a kernel that it calls, or a constant
    that one of them reads: see `fingerprint`.
    """
    compiled = njit(fastmath=FAST)(function)
    if hasattr(compiled, '_cache'):  # not where NUMBA_DISABLE_JIT is set
        compiled._cache = _Cache(function)
        _KERNELS.append(compiled)
    return compiled


def written_into_kernels(function: Kernel) -> Kernel:
    """
    Take a part of a kernel that is written into each that calls it, before they are compiled.

    A call leaves the compiler less to reorder: a kernel that has it is slower, and rounds
    otherwise, than one that does all by itself.
    """
    part: Kernel = njit(inline='always', fastmath=FAST)(function)
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


def fingerprint(function: Callable[..., Any]) -> str:
    """
    Return what changes with the machine code of a function, and with nothing else of its source.

    Parameters
    ----------
    function : callable
        A Python function whose globals are all defined.

    Returns
    -------
    str
        Digest of the byte code of the function and of all kernels that it calls, and of the
        constants that they read. Comments, docstrings, annotations, line numbers and the place of
        the file do not enter.

    Raises
    ------
    TypeError
        Where one of them reads a global of a kind that cannot be told apart by its value.

    """
    found: dict[str, object] = {}
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if _name(one) not in found:
            found[_name(one)] = _parts(one, waiting)
    whole = [sorted(FAST), _name(function), *sorted(found.items())]
    return sha256(repr(whole).encode()).hexdigest()


class _Files(CompileResultCacheImpl):
    """Numba's names of the files, without the line that the function begins in."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        with_line: str = super().get_filename_base(fullname, abiflags)
        return with_line.replace(f'-{self.locator.get_disambiguator()}.', '.', 1)


class _Index(IndexDataCacheFile):
    """Numba's list of the machine code of one kernel, by the types of its arguments."""

    def _load_index(self) -> dict[Any, str]:
        try:
            found: dict[Any, str] = super()._load_index()
        except (AttributeError, ImportError):  # a class among them has another name by now
            return {}
        return found


class _Cache(FunctionCache):
    """
    Numba's cache, which asks whether the kernel's fingerprint is that of the machine code.

    Numba itself asks whether the kernel's own file is as it was. A change in a kernel that is
    compiled into it would escape that, and every change of a comment would not.
    """

    _impl_class = _Files

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        del self._cache_file  # it has the stamp of the file

    @cached_property
    def _cache_file(self) -> _Index:
        # Only when it is needed: what the kernel calls may be defined after it.
        return _Index(self.cache_path, self._impl.filename_base, fingerprint(self._py_func))


def _name(function: Callable[..., Any]) -> str:
    return f'{function.__module__}.{function.__qualname__}'


def _parts(function: Any, called: list[Callable[..., Any]]) -> object:
    """Return what the function itself is compiled from; add what it calls to the list."""
    code: CodeType = function.__code__
    read = _names(code)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    values = {name: function.__globals__[name] for name in read if name in function.__globals__}
    values |= dict(zip(code.co_freevars, cells, strict=True))
    modules: list[ModuleType] = []

    def described(value: Any) -> object:
        if hasattr(value, 'py_func'):
            value = value.py_func  # another kernel
        if isinstance(value, ModuleType):
            # Of which module an attribute is taken, the byte code does not say in one place.
            within = () if value in modules else sorted(read & vars(value).keys())
            modules.append(value)
            return value.__name__, [(name, described(vars(value)[name])) for name in within]
        if isinstance(value, FunctionType) and _root(value) == _root(function):
            called.append(value)
            return _name(value)
        if isinstance(value, type) and issubclass(value, tuple):
            return value.__qualname__, getattr(value, '_fields', ())
        if isinstance(value, (tuple, list)):
            return type(value).__qualname__, list(map(described, value))
        if isinstance(value, frozenset):
            return sorted(repr(described(each)) for each in value)
        if isinstance(value, np.ndarray):
            return str(value.dtype), value.shape, value.tobytes()
        if isinstance(value, CONSTANTS):
            return type(value).__qualname__, repr(value)
        if callable(value):  # of NumPy or Python: they have versions of their own
            return getattr(value, '__name__', repr(type(value)))
        raise TypeError(f'the kernel {_name(function)} reads a {type(value).__name__}')

    def compiled_from(code: CodeType, docstring: str | None = None) -> object:
        constants = [
            compiled_from(each) if isinstance(each, CodeType) else described(each)
            for each in code.co_consts if docstring is None or each != docstring
        ]
        return (
            code.co_code, constants, code.co_names, code.co_varnames, code.co_freevars,
            code.co_flags, code.co_argcount, code.co_kwonlyargcount,
            getattr(code, 'co_exceptiontable', b''),  # from Python 3.11 on
        )

    return (
        compiled_from(code, function.__doc__),
        described(function.__defaults__),
        [(name, described(value)) for name, value in sorted(values.items())],
    )


def _names(code: CodeType) -> set[str]:
    """Return the names that code looks up, also those of the functions in it."""
    within = [_names(each) for each in code.co_consts if isinstance(each, CodeType)]
    return set(code.co_names).union(*within)


def _root(function: FunctionType) -> str:
    return function.__module__.partition('.')[0]

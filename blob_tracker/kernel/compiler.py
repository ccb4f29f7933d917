"""Kernels by way of Numba, and what of their machine code can be used without it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, partial
import pickle
from typing import Any

from blob_tracker.kernel.changes import fingerprint, licence
from blob_tracker.kernel.kept import CODES, Kept
from blob_tracker.kernel.machine_code import link, MachineCodeError
from blob_tracker.kernel.notice import compiling
from numba import njit, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.np.numpy_support import as_dtype
import numpy as np

SCALARS = {
    types.float64: CODES.FLOAT, types.int64: CODES.INTEGER, types.boolean: CODES.BOOLEAN,
    types.none: CODES.NONE, types.unicode_type: CODES.TEXT,
}
NUMBERS_WRITTEN_OUT = types.IntegerLiteral, types.BooleanLiteral


def compiler(function: Callable[..., Any], inline: str = 'never') -> Any:
    """Return Numba's dispatcher for a kernel, which keeps its machine code on disk."""
    found = njit(inline=inline, fastmath=licence(function))(function)
    # Not where NUMBA_DISABLE_JIT is set, nor for what is only ever a part of others.
    if inline == 'never' and hasattr(found, '_cache'):
        found._cache = _Cache(function)
        found.get_call_template = partial(_call_template, found.get_call_template)
    return found


def _call_template(template: Callable[..., Any], values: Any, named: Any) -> Any:
    """
    Return how one kernel calls another: with a number that is written out as with any other.

    Numba would compile the kernel that is called once more for each of them, and for all that it
    calls in turn; a path that is seldom taken would be compiled when it first is.
    """
    return template(
        tuple(map(_of_any_value, values)),
        {name: _of_any_value(value) for name, value in named.items()},
    )


def _of_any_value(one: Any) -> Any:
    return types.unliteral(one) if isinstance(one, NUMBERS_WRITTEN_OUT) else one


def wrappers(
    dispatcher: Any, but: set[Any]
) -> Iterator[tuple[Any, Kept | None, int]]:
    """
    Yield the signatures that a dispatcher has, but for some.

    Yields
    ------
    signature : tuple
        Numba's types of the arguments.
    kept : Kept or None
        What can be kept of it; None if it takes Numba to call it.
    address : int
        Where its wrapper is, in this process.

    """
    for signature, result in dispatcher.overloads.items():
        if signature in but:
            continue
        try:
            kept = _kept(dispatcher._cache.on_disk(signature, result))
            yield signature, kept, result.library.get_pointer_to_function(kept.wrapper)
        except (
            AttributeError, MachineCodeError, TypeError, ValueError, pickle.PicklingError,
        ):
            yield signature, None, 0


def _kept(reduced: Any) -> Kept:
    """Return what the machine code of one signature needs; or raise, where Numba is part of it."""
    (_, kind, code), described, own, _, objectmode, lifted, _, reload_init, others = reduced
    if kind != 'object' or objectmode or lifted or reload_init:
        raise TypeError('needs Numba when it is called')
    classes: list[type] = []
    codes = [code for one in described.argtypes for code in _codes(one, classes)]
    environments = {
        one.env_name: (one.globals['__name__'], list(one.consts)) for one in (own, *others)
    }
    return Kept(
        codes=np.array(codes, np.int32).tobytes(),
        values=len(described.argtypes),
        wrapper=described.llvm_cpython_wrapper_name,
        image=link(bytes(code[0])),
        # Loaded later than the rest: a class may have another name by then.
        pickled=pickle.dumps((tuple(classes), environments)),
    )


def _codes(one: Any, classes: list[type]) -> Iterator[int]:
    """Yield what tells the type of an argument, as `direct.c` has it."""
    if one in SCALARS:
        yield SCALARS[one]
    elif type(one) is types.Array and one.aligned:
        dtype = as_dtype(one.dtype)
        if dtype.kind not in 'biufc':
            raise TypeError(f'array of {dtype}')
        yield from (CODES.ARRAY, ord(dtype.kind), dtype.itemsize, one.ndim, ord(one.layout))
        yield int(one.mutable)
    elif isinstance(one, types.BaseTuple):
        of = getattr(one, 'instance_class', tuple)
        if of not in classes:
            classes.append(of)
        yield from (CODES.TUPLE, classes.index(of), len(one))
        for each in one:
            yield from _codes(each, classes)
    else:
        raise TypeError(f'argument of type {one}')


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

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what there is of one signature; None has Numba compile it."""
        found = super().load_overload(sig, target_context)
        if found is None:
            compiling()
        return found

    def on_disk(self, signature: Any, result: Any) -> Any:
        """Return what Numba has written of one signature: see its `CompileResult._rebuild`."""
        return self._cache_file.load(self._index_key(signature, result.codegen))

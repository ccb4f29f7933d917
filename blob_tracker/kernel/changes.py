"""What machine code depends on: the byte code and the constants that it is compiled from."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Everything but the licence to ignore NaN and infinity: a masked pixel's variance is infinite.
FAST = {'reassoc', 'contract', 'nsz', 'arcp'}
EXACT: set[str] = set()  # the arithmetic of Python
# What a kernel may read, and what its repr tells all of.
PLAIN = (bool, int, float, complex, str, bytes, type(None), type(...))
CONSTANTS = (*PLAIN, np.generic, np.dtype)


def licence(function: Callable[..., Any]) -> set[str]:
    """Return by what a kernel's arithmetic may depart from Python's: see `exact_kernel`."""
    return EXACT if getattr(function, 'is_exact', False) else FAST


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
        constants that they read, arrays of floats to twelve digits. Comments, docstrings,
        annotations, line numbers and the place of the file do not enter.

    Raises
    ------
    TypeError
        If one of them reads a global of a kind that cannot be told apart by its value.

    """
    found: dict[str, str] = {}
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if _name(one) not in found:
            found[_name(one)], called = _described(one)
            waiting += called
    parts = ', '.join(f'({name!r}, {text})' for name, text in sorted(found.items()))
    whole = f'[{sorted(licence(function))!r}, {_name(function)!r}, {parts}]'
    return sha256(whole.encode()).hexdigest()


def _name(function: Callable[..., Any]) -> str:
    return f'{function.__module__}.{function.__qualname__}'


@cache  # many kernels call the same few
def _described(function: Callable[..., Any]) -> tuple[str, list[Callable[..., Any]]]:
    """Return in words what the function itself is compiled from, and what it calls."""
    called: list[Callable[..., Any]] = []
    return repr(_parts(function, called)), called


def _parts(function: Any, called: list[Callable[..., Any]]) -> object:
    """Return what the function itself is compiled from; add what it calls to the list."""
    code: CodeType = function.__code__
    read = _names(code)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    values = {name: function.__globals__[name] for name in read if name in function.__globals__}
    values |= dict(zip(code.co_freevars, cells, strict=True))
    modules: list[ModuleType] = []

    def described(value: Any) -> object:
        if type(value) in PLAIN:  # most are
            return type(value).__qualname__, repr(value)
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
            return str(value.dtype), value.shape, *_digits(value)
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


def _digits(values: NDArray[Any]) -> tuple[object, ...]:
    """
    Return what tells arrays of constants apart: all, of floats but for their last digits.

    The last bits of what NumPy's functions give depend on the processor's instructions, and
    machine code for any x86-64 is to serve on each.
    """
    scale = float(np.abs(values).max(initial=0.0)) if values.dtype.kind == 'f' else 0.0
    if not 0.0 < scale < np.inf:
        return (values.tobytes(),)
    return f'{scale:.12g}', (np.round(values / scale, 12) + 0.0).tobytes()  # -0.0 is 0.0


def _names(code: CodeType) -> set[str]:
    """Return the names that code looks up, also those of the functions in it."""
    within = [_names(each) for each in code.co_consts if isinstance(each, CodeType)]
    return set(code.co_names).union(*within)


def _root(function: FunctionType) -> str:
    return function.__module__.partition('.')[0]

"""What compiled kernels call: the parts of Numba that are not its compiler."""

from __future__ import annotations

import builtins
import ctypes
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
import pickle
import sys
from types import ModuleType

from blob_tracker.kernel.direct import UNPICKLE
from blob_tracker.kernel.kept import Kept
from blob_tracker.kernel.machine_code import load, MachineCodeError

# The order is that in which Numba imports them.
HELPERS, ENVIRONMENT, MEMORY = '_helperlib', '_dynfunc', 'core.runtime._nrt_python'
# Functions of C that Numba takes from its helpers: another version of a function, other bits.
MATH = (
    'acos acosh asin asinh atan atan2 atanh ceil cos cosh exp expm1 fabs floor fmod log log10 '
    'log1p pow round sin sinh sqrt tan tanh trunc'
).split()
_ALIVE: list[object] = []  # environments, which the machine code has the addresses of


def placed(kept: Kept) -> tuple[tuple[type, ...], int] | None:
    """
    Load machine code.

    Returns
    -------
    classes : tuple of type
        Of the named tuples that it takes.
    address : int
        Of the wrapper.

    None if it cannot be loaded: Numba makes it, then.

    """
    try:
        classes, environments = pickle.loads(kept.pickled)
        symbols = load(kept.image, _known())
        environment = _extension(ENVIRONMENT).Environment
        for name, (module, constants) in environments.items():
            if name in symbols:
                # Numba's own functions have some as well. Only its object mode looks into it.
                around = vars(sys.modules[module]) if module in sys.modules else {}
                made = environment(around)
                made.consts[:] = constants
                _ALIVE.append(made)
                ctypes.c_void_p.from_address(symbols[name]).value = id(made)
        return classes, symbols[kept.wrapper]
    except (
        AttributeError, ImportError, KeyError, MachineCodeError, StopIteration,
        pickle.UnpicklingError,
    ):
        return None


@cache
def _known() -> dict[str, int]:
    """Return the addresses of what Numba brings, by the names in the machine code."""
    known = {
        f'PyExc_{name}': id(one) for name, one in vars(builtins).items()
        if isinstance(one, type) and issubclass(one, BaseException)
    }
    known['_Py_NoneStruct'] = id(None)
    helpers = _extension(HELPERS).c_helpers
    known |= {name: helpers[name] for one in MATH for name in (one, f'{one}f')}
    for part in (HELPERS, ENVIRONMENT):
        known |= {f'numba_{name}': at for name, at in _extension(part).c_helpers.items()}
    for name, at in _extension(MEMORY).c_helpers.items():
        known[name if name.startswith('_') else f'NRT_{name}'] = at
    return known | {'numba_unpickle': UNPICKLE}


def _extension(name: str) -> ModuleType:
    """Import an extension of Numba without the package around it."""
    whole = f'numba.{name}'
    if whole not in sys.modules:
        spec = find_spec('numba')
        if spec is None or spec.origin is None:
            raise ImportError('no numba')
        stem = Path(spec.origin).parent.joinpath(*name.split('.'))
        path = next(
            path for path in (f'{stem}{suffix}' for suffix in EXTENSION_SUFFIXES)
            if Path(path).exists()
        )
        found = spec_from_file_location(whole, path, loader=ExtensionFileLoader(whole, path))
        assert found is not None and found.loader is not None
        module = module_from_spec(found)
        found.loader.exec_module(module)
        # Numba takes it from here when it is imported: there is one of each in a process.
        sys.modules[whole] = module
    return sys.modules[whole]

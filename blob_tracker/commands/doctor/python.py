"""Python and the libraries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module, metadata
from pathlib import Path
import sys
import sysconfig

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn

OLDEST, NEWEST = (3, 10), (3, 13)
# Module -> its name on PyPI and on Ubuntu.
REQUIRED = {
    'numpy': ('numpy', 'python3-numpy'),
    'scipy': ('scipy', 'python3-scipy'),
    'cv2': ('opencv-python-headless', 'python3-opencv'),
    'numba': ('numba', 'python3-numba'),
    'yaml': ('PyYAML', 'python3-yaml'),
    'rich': ('rich', 'python3-rich'),
}
OPTIONAL = {
    'matplotlib': ('matplotlib', 'python3-matplotlib', 'the pictures of demo and calibrate'),
    'rosbags': ('rosbags', '', '`python3 -m blob_tracker replay` and calibrations from bags'),
}


def check_python(version: tuple[int, int] = sys.version_info[:2]) -> Iterator[Finding]:
    """Look at the version of Python."""
    words = f'{version[0]}.{version[1]}, {sys.executable}'
    if OLDEST <= version <= NEWEST:
        yield ok('Python', words)
        return
    yield error(
        'Python',
        f'{words}; blob_tracker runs on 3.10 to 3.13',
        'Ubuntu 24.04 has 3.12; elsewhere make a virtual environment of one of these',
        'python3.12 -m venv .venv',
    )


def check_libraries(
    required: Mapping[str, tuple[str, str]] = REQUIRED,
    optional: Mapping[str, tuple[str, str, str]] = OPTIONAL,
) -> Iterator[Finding]:
    """Import each library and tell its version; a broken one is as good as none."""
    found = []
    for module, (wheel, package) in required.items():
        try:
            found.append(f'{wheel} {_version(module, wheel)}')
        except Exception as fault:  # numba on a numpy it does not know raises its own
            yield error('libraries', _missing(module, fault), *_install(wheel, package))
    for module, (wheel, package, purpose) in optional.items():
        try:
            found.append(f'{wheel} {_version(module, wheel)}')
        except Exception as fault:
            yield warn(
                'libraries', f'{_missing(module, fault)}; {purpose} need it',
                *_install(wheel, package),
            )
    if found:
        yield ok('libraries', ', '.join(found))


def _version(module: str, wheel: str) -> str:
    """Return the version of a library; Ubuntu's OpenCV has no metadata, rich no __version__."""
    imported = import_module(module)
    try:
        return str(getattr(imported, '__version__', None) or metadata.version(wheel))
    except metadata.PackageNotFoundError:
        return 'of unknown version'


def _missing(module: str, fault: Exception) -> str:
    if isinstance(fault, ModuleNotFoundError) and fault.name == module:
        return f'{module} is not installed'
    return f'{module} cannot be imported: {type(fault).__name__}: {fault}'


def _install(wheel: str, package: str) -> tuple[str, str]:
    """Return the advice and the command for this kind of Python."""
    if sys.prefix == sys.base_prefix and package:  # no virtual environment
        return 'install it', f'sudo apt install {package}'
    # Outside of a virtual environment pip refuses where the distribution says so (PEP 668).
    managed = (Path(sysconfig.get_path('stdlib')) / 'EXTERNALLY-MANAGED').is_file()
    forced = managed and sys.prefix == sys.base_prefix
    option = '--break-system-packages ' if forced else ''
    return 'install it', f'{sys.executable} -m pip install {option}{wheel}'

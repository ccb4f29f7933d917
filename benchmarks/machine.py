"""What the figures were measured on."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
import platform
import subprocess

PACKAGES = (
    'numpy', 'scipy', 'numba', 'opencv-python-headless',
    'photutils', 'astropy', 'sep', 'trackpy', 'picassosr', 'filterpy',
)


def describe() -> dict[str, object]:
    """Return the processor's name, Python's version and the packages'; None if missing."""
    return {
        'cpu': _processor(),
        'python': platform.python_version(),
        'packages': {package: _version(package) for package in PACKAGES},
    }


def commit() -> str:
    """Return the abbreviated commit that is checked out; empty if that cannot be known."""
    try:
        found = subprocess.run(
            ['git', 'rev-parse', '--short', 'HEAD'], cwd=Path(__file__).parent,
            capture_output=True, text=True, check=False,
        )
    except OSError:
        return ''
    return found.stdout.strip()


def _processor() -> str:
    listing = Path('/proc/cpuinfo')
    if listing.exists():
        for line in listing.read_text().splitlines():
            if line.startswith('model name'):
                return line.partition(':')[2].strip()
    return platform.processor() or platform.machine()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None

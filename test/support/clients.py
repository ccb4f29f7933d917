"""The clients of ROS 2 that its packages of apt bring, and no registry of Python."""

from __future__ import annotations

from ament_index_python.packages import get_package_prefix, PackageNotFoundError
import pytest

REASON = 'only ROS 2 from apt has '


def needs(*packages: str) -> None:
    """Skip a test, or the file that begins with this, unless all of these are installed."""
    for package in packages:
        try:
            get_package_prefix(package)
        except PackageNotFoundError:
            pytest.skip(REASON + ', '.join(packages), allow_module_level=True)

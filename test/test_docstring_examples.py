"""The examples in docstrings do what they say."""

from __future__ import annotations

import doctest
from importlib import import_module
from pathlib import Path

import blob_tracker
import pytest

PACKAGE = Path(blob_tracker.__file__).parent
MODULES = sorted(
    '.'.join(path.relative_to(PACKAGE.parent).with_suffix('').parts)
    for path in PACKAGE.rglob('*.py') if '\n    >>> ' in path.read_text()
)


@pytest.mark.parametrize('module', MODULES)
def test_examples_hold(module: str) -> None:
    """Each is run as it stands."""
    assert doctest.testmod(import_module(module)).failed == 0


@pytest.mark.parametrize('name', blob_tracker.__all__)
def test_what_the_package_exports_has_an_example(name: str) -> None:
    """One that runs."""
    found = doctest.DocTestFinder().find(getattr(blob_tracker, name), name)
    assert any(test.examples for test in found)
